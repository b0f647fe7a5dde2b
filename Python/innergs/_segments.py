"""Segments of a model by name."""

from __future__ import annotations

import collections

from ._jobs import Job
from ._scene import Error, call, checked, logic_of, quiet

Found = collections.namedtuple("Found", "answer sentence candidates")
Found.__doc__ = """How a query was understood: answer "found", "several" (side or number is open), "wider" (only segments that hold
more), "not in volume", "no match" or "similar" (words that the lexicon does not know, segments near in meaning by the
sentence embedding in the folder INNERGS_TEXT_MODEL); a sentence; (name, score) of the segments that fit, best first, score from 0 to 1."""

_ANSWERS = ("found", "several", "wider", "not in volume", "no match", "similar")  # vtkInnerGSSegment's Answers


def learn(model, labels=None, sparse=False, progress=None, features=None, texts="", network="", names=(), value_range=(0, 0),
          spacing=0.0):
    """Teaches a model segments of the same patient and waits; returns the model, which keeps and saves them.

    A model of a dynamic scan learns from labels of the time that set_time() chose.

    labels    a segmentation or labelmap node, whose names come from its colour table; sparse: unlabelled slices
              between labelled ones follow the scan
    features  instead: a volume node with several values per voxel; texts: a JSON file with embeddings of texts,
              {"liver": [0.1, 0.2], "background": [0, 1]}
    network   or: an ONNX file that OpenVINO runs on the model's own image; names: of its channels 1, 2, ..., or texts
    value_range, spacing  for the network: values that become 0 and 1 (equal: mean 0 and standard deviation 1), size of its
              voxels in mm (0: as in the fit)
    progress  called with the Job from time to time
    """
    if sum(bool(teacher) for teacher in (labels, features, network)) > 1:
        raise Error("Give one teacher: labels, features or a network.")
    owner = logic_of(model)
    with quiet(owner):
        if features:
            job = owner.StartLearningFromFeatures(model, features, str(texts))
        elif network:
            job = owner.StartLearningFromNetwork(model, str(network), _string_array(names), str(texts), *value_range, spacing)
        else:
            job = owner.StartLearning(model, labels, sparse)
        job = checked(owner, job)
    return Job(owner, job, progress=progress).result().model


def _string_array(names):
    from vtkmodules.vtkCommonCore import vtkStringArray

    array = vtkStringArray()
    for name in names:
        array.InsertNextValue(name)
    return array


def find(model, text):
    """What a query such as "left kidney" means, as Found; creates nothing."""
    from vtkmodules.vtkCommonDataModel import vtkTable

    owner = logic_of(model)
    table = vtkTable()
    with quiet(owner):
        kind = owner.FindByText(model, text, table)
    if kind < 0:
        raise Error(owner.GetLastError(), owner.GetLastErrorCode())
    candidates = [(table.GetValueByName(row, "Name").ToString(), table.GetValueByName(row, "Score").ToDouble())
                  for row in range(table.GetNumberOfRows())]
    return Found(_ANSWERS[kind], owner.GetLastAnswer(), candidates)


def segment(model, text, output=None, threshold=0.0, largest_only=False, minimum_size=0.0, smoothing=0.0, spacing=0.0):
    """Segments by name, as a segmentation node: `output` or a new one, with terminology and colours.

    A dynamic model gives those at the time of set_time().

    text          one structure in words, or a list of them; both sides where the side is open
    threshold     of the probability, 0 to 1; 0: where the segment is the likeliest
    largest_only  only the largest connected part of each segment; minimum_size: of connected parts, mm3
    smoothing     standard deviation of a Gaussian in mm; spacing: of the voxels in mm, 0: as in the fit
    """
    for one in [text] if isinstance(text, str) else text:
        output = call("SegmentByText", model, one, output, threshold, largest_only, minimum_size, smoothing, spacing)
    return output


def score(model, text, output=None, spacing=0.0):
    """The probability of what a query means, 0 to 1, as a volume node: `output` or a new one.

    For several segments, that of the likeliest; for a dynamic model, at the time of set_time(). spacing: of the
    voxels in mm, 0: as in the fit.
    """
    return call("ScoreByText", model, text, output, spacing)
