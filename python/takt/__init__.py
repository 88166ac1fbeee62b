"""takt in Python: runs of scenario files, programs of cells, recordings as arrays (docs/python.md)."""
from . import command, conditions, sweeps
from ._step_operations import *  # noqa: F403  takt.lin(...): a step of a program tree
from ._channels import CellChannel
from ._cell import Arm, Cell, Gripper, Output, ToolChanger, TwoArms, open
from ._errors import Cancelled, Diagnostic, Error, OpenError, OperationError, RecordingError, UsageError
from ._recording import Channel, Comparison, Curve, Recording, compare, open_recording
from ._report import Expectation, Report
from ._run import check, main, run
from ._run_handles import Activity, Outcome, Reaction, Run
from ._takt import Frame, Joints, Pose, Real, State, Twist, Vector, Wrench
from .sweeps import between, sweep
from ._tree import Scenario, Step, branch, call, charts, fail, for_each, krl, let, log, parallel, repeat, sequence, stop, tree, try_, urscript
from ._takt import version as __version__


def __getattr__(name: str):  # type: ignore[no-untyped-def]
    """takt.gym is imported when it is first used: it needs Gymnasium."""
    if name == "gym":
        import importlib
        return importlib.import_module("takt.gym")
    raise AttributeError(f"module 'takt' has no attribute '{name}'")

__all__ = [
    "Activity", "Arm", "Cancelled", "Cell", "CellChannel", "Channel", "Comparison", "Curve", "Diagnostic", "Error", "Expectation",
    "Frame", "Gripper", "Joints", "OpenError", "OperationError", "Outcome", "Output", "Pose", "Reaction", "Real",
    "Recording", "RecordingError", "Report", "Run", "Scenario", "State", "Step", "ToolChanger", "Twist", "TwoArms", "UsageError", "Vector",
    "Wrench", "between", "branch", "call", "charts", "check", "command", "compare", "conditions", "fail", "for_each", "krl", "let", "log", "main", "open",
    "open_recording", "parallel", "repeat", "run", "sequence", "stop", "sweep",
    "sweeps", "tree", "try_",
]
