"""Plain words for what recorded motion can tell about weights, and what it cannot."""

from collections.abc import Sequence

from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.report.theme import words

WHAT_WEIGHTS_ARE = (
    "A weight says how costly it is for this person to move a joint in order to move the hand. "
    "Only ratios mean something: doubling all weights changes nothing that can be observed."
)
WHAT_GROUPS_ARE = (
    "Two joints can be compared only if they can stand in for each other: if some movement of "
    "both leaves the hand where it is. Joints that can be compared, directly or through others, "
    "form a group; the largest weight of each group is set to 1, and weights of different groups "
    "have nothing to do with each other."
)
WHAT_NOT_IDENTIFIED_IS = (
    "A joint is given no weight where the data cannot tell it: because no other joint could do "
    "its work, because it did not move, because the movements made did not call on the choice, "
    "or because the uncertainty is larger than the factor e (2.7). Such a joint is shown in words "
    "and not as a number."
)


def explain_identifiability(estimate: WeightEstimate) -> tuple[str, ...]:
    """Say of one estimate which joints can be compared, and why the others cannot.

    Returns:
        Sentences, one for each group and one for each joint without a weight.
    """
    sentences = [_group(estimate, group) for group in estimate.groups]
    sentences += [
        f"{words(joint).capitalize()} has no weight: {reason}."
        for joint, reason in estimate.unidentifiable.items()
    ]
    if not estimate.groups:
        sentences.insert(0, "No two joints can be compared with these movements.")
    return tuple(sentences)


def _group(estimate: WeightEstimate, group: Sequence[str]) -> str:
    place = {joint: estimate.joints.index(joint) for joint in group}
    ranked = sorted(group, key=lambda joint: estimate.weights[place[joint]])
    cheap, dear = ranked[0], ranked[-1]
    ratio = estimate.weights[place[dear]] / estimate.weights[place[cheap]]
    names = ", ".join(words(joint) for joint in group)
    return (
        f"{names[0].upper()}{names[1:]} can be compared: {words(cheap)} is moved most readily, "
        f"{words(dear)} is {ratio:.2g} times as costly."
    )
