"""Methods on many people and trials: the papers computed again, and anyone's own recordings.

A study gives tables and arrays; `report` draws them. Named after a paper: its reproduction. The
rest runs on recordings that a study file describes (`study_file`), or on simulated people.
"""
