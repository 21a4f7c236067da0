"""An association of your own: the pair with the highest score, then the best of those left."""

import numpy as np

from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.registry import association


@association("greedy")
def greedy(question: Question) -> Assignment:
    """Called for each image; nobody chooses before the others here."""
    hypotheses = question.hypotheses
    chosen = np.zeros(len(hypotheses.score), bool)
    alone, unexplained = np.ones(len(question.first), bool), np.ones(len(question.echoes), bool)
    for pair in np.argsort(-hypotheses.score):
        of_object, of_echo = hypotheses.objects[pair], hypotheses.echoes[pair]
        if hypotheses.score[pair] > 0.0 and alone[of_object] and unexplained[of_echo]:
            chosen[pair] = True
            alone[of_object] = unexplained[of_echo] = False
    pairs = hypotheses.take(chosen)
    return Assignment(pairs, question.echoes.take(pairs.echoes), ~unexplained)
