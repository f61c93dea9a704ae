"""The parts of weight identification ([Khoramshahi2022]); its verbs are in `identification`."""
