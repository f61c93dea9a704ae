"""The parts of the passive motion planner ([Tommasino2017]); its verbs are in `passive_motion`."""
