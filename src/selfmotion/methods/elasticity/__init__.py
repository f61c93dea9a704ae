"""The parts of the elasticity fit by Donders' law ([Tommasino2017]); its verbs are in `donders`."""
