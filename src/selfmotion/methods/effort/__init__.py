"""The parts of the natural posture by muscle effort ([Li2022]); verbs in `natural_posture`."""
