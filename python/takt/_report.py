"""What came of a run."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ._errors import Diagnostic, diagnostics_of, refuse
from ._options import Kept

if TYPE_CHECKING:
    from ._recording import Channel, Device, Recording


@dataclass(frozen=True)
class Expectation:
    """A statement about the run, and whether it held."""

    name: str
    kind: str
    passed: bool
    measured: str
    value: float | None = None
    unit: str = ""
    lower: float | None = None
    upper: float | None = None
    judged: bool = True


class Report:
    """The verdict of a run, and its channels: report["wrist"].force, report["/left/joint_states"]."""

    def __init__(self, report: dict[str, Any], kept: Kept):
        self.report = report
        self._kept = kept
        self._recording: "Recording | None" = None

    @property
    def passed(self) -> bool:
        return self.result == "passed"

    @property
    def result(self) -> str:
        """passed, failed, error or interrupted."""
        return str(self.report["result"])

    @property
    def digest(self) -> str:
        """32 hexadecimal digits over every bit of every cycle."""
        return str(self.report["digest"])

    @property
    def title(self) -> str:
        return str(self.report["title"])

    @property
    def sim_time(self) -> float:
        """s"""
        return float(self.report["sim_time"])

    @property
    def cycles(self) -> int:
        return int(self.report["cycles"])

    @property
    def expectations(self) -> list[Expectation]:
        return [Expectation(**one) for one in self.report["expectations"]]

    @property
    def events(self) -> list[dict[str, Any]]:
        """What happened: time, level, source, name, text, step."""
        return list(self.report["events"])

    @property
    def lines(self) -> list[str]:
        """What the program printed."""
        return list(self.report["lines"])

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """Why it is an error."""
        return diagnostics_of(self.report["diagnostics"])

    @property
    def warnings(self) -> list[Diagnostic]:
        """Of the file."""
        return diagnostics_of(self.report["warnings"])

    @property
    def recording(self) -> "Recording":
        """Its recording. Refused for a run with record=False."""
        if self._recording is None:
            if self._kept.path is None:
                raise refuse("requires", "record", "the run was not recorded", "Give record=True, or the name of a file")
            from ._recording import open_recording
            self._recording = open_recording(self._kept.path)
        return self._recording

    def __getitem__(self, name: str) -> "Device | Channel":
        return self.recording[name]

    def to_arrow(self, name: str | None = None) -> Any:
        """A topic, or a part of a device ("left.position"), as a table of pyarrow, with time in s; without a name all
        topics by theirs."""
        return self.recording.to_arrow(name)

    def __repr__(self) -> str:
        return f"<run '{self.title}': {self.result}, {self.sim_time:.3f} s, digest {self.digest}>"

    def __str__(self) -> str:
        rows = [f"{self.title}: {self.result}"]
        for one in self.expectations:
            mark = "ok  " if one.passed else "FAIL" if one.judged else "open"
            rows.append(f"  {mark} {one.name:<28} {one.measured}")
        rows.append(f"  {self.sim_time:.3f} s simulated, {self.cycles} cycles, digest {self.digest}")
        rows += [f"  {one}" for one in self.diagnostics]
        return "\n".join(rows)
