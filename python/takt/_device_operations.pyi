"""Printed by `python3 -m takt.stubs` from the tables of operations: do not edit."""
from typing import Any, Callable, Concatenate, Generic, Literal, Mapping, ParamSpec, Sequence

import numpy as np
import numpy.typing as npt

from ._run_handles import Activity, Run
from ._takt import Frame, State
from ._takt import Goal as CoreGoal
from .conditions import Condition

Array = npt.NDArray[np.float64]
Numbers = Sequence[float] | Array
Until = State | Condition | Mapping[str, Any]
Goal = Literal["home"] | Array | Frame | CoreGoal | Mapping[str, Any]
P = ParamSpec("P")

class Operation(Generic[P]):
    def __call__(self, *arguments: P.args, **keywords: P.kwargs) -> Run: ...
    def activity(self, *arguments: P.args, **keywords: P.kwargs) -> Activity: ...
    def begin(self, *arguments: P.args, **keywords: P.kwargs) -> Run: ...
    def schedule(self, *arguments: P.args, **keywords: P.kwargs) -> Run: ...

class StepOperation(Generic[P]):
    def __call__(self, *arguments: P.args, **keywords: P.kwargs) -> None: ...

def operation(method: Callable[Concatenate[Any, P], Run]) -> Operation[P]: ...
def step(method: Callable[Concatenate[Any, P], None]) -> StepOperation[P]: ...

class ArmOperations:
    @operation
    def circ(
        self, to: Goal | None = ..., via: Goal | None = ..., *, tool: str | None = ..., tcp: str | None = ...,
        about: Any | None = ..., orientation: Literal["goal", "fixed", "tangential"] | None = ...,
        speed: float | None = ..., acceleration: float | None = ..., velocity_m_s: float | None = ...,
        follower: str | None = ..., compliance: Any | None = ..., weave: Any | None = ...,
        force_offset: Any | None = ..., until: Until | None = ..., on_end: Literal["fail", "continue"] | None = ...,
        abort_if: Until | None = ..., blend_m: float | None = ..., blend_fraction: float | None = ...,
        blend: float | None = ..., X_FM: Array | None = ...
    ) -> Run:
        """Moves the tool centre point on a circle.

        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        to: Goal at the end of the arc; not with 'about'. (goal; optional)
        via: Via pose; its position counts. Not with 'about'. (goal; optional)
        about: Centre, axis and angle in place of 'to' and 'via'. (about; optional)
        orientation: How the tool turns along the arc. (goal, fixed, tangential; default goal; with 'about' fixed)
        speed: Share of the velocity limits. (number, above 0, at most 1; default 1)
        acceleration: Share of the acceleration and jerk limits. (number, above 0, at most 1; default 1)
        velocity_m_s: Speed of the tool centre point. (number in m/s, above 0; optional)
        follower: Second arm that moves as one with this one. (name of an arm; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        weave: Oscillation across the path. (weave; optional)
        force_offset: Shift of the path that holds a force. (force_offset; optional)
        until: Guarded motion: brakes on its path when this becomes true. (condition; optional)
        on_end: Whether a guarded motion that reaches its goal fails. (fail, continue; default fail)
        abort_if: Brakes on its path and fails when this becomes true. (condition; optional)
        blend_m: Distance from the goal at which the next motion takes over. (number in m, at least 1e-05; optional)
        blend_fraction: The same as a share of the path. (number, at least 0.0001, at most 0.5; optional)
        blend: share of its time from which the next motion may take over, 0.5 to 1 (optional)
        X_FM: pose of the frame that moves, in the flange, 4x4 in m (optional)
        """
    @operation
    def control_mode(self, mode: Literal["position", "joint_impedance", "cartesian_impedance"]) -> Run:
        """Brings an arm into a control mode while nothing holds it.

        mode: The new control mode. (position, joint_impedance, cartesian_impedance; required)
        """
    @operation
    def follow(
        self, seconds: float | None = ..., *, until: Until | None = ..., tool: str | None = ...,
        tcp: str | None = ..., compliance: Any | None = ..., abort_if: Until | None = ...,
        linear_max_m_s: float | None = ..., angular_max_deg_s: float | None = ..., channel: str | None = ...,
        in_: str | None = ...
    ) -> Run:
        """The tool follows a moving frame, or the poses of a channel.

        seconds: Ends after this time. (number in s, at least 0, at most 3600; optional)
        until: Ends when this becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        linear_max_m_s: Largest speed of the tool. (number in m/s, above 0, at most 1; default 0.1)
        angular_max_deg_s: Largest angular speed of the tool. (number in deg/s, above 0, at most 180; default 28.6479)
        channel: Channel of type Frame: the pose of the tool in 'in'. (text; optional)
        in_: Frame that the tool follows; with a channel the frame of its poses. (text; optional)
        """
    @operation
    def freedrive(
        self, enabled: Until | None = ..., *, until: Until | None = ..., seconds: float | None = ...,
        velocity_m_s: float | None = ..., turn_deg_s: float | None = ..., abort_if: Until | None = ...,
        tool: str | None = ..., tcp: str | None = ...
    ) -> Run:
        """A person guides an arm by hand.

        enabled: Dead-man switch: the arm yields only while this is true. (condition; optional)
        until: Ends when this becomes true. (condition; optional)
        seconds: Ends after this time. (number in s, at least 0, at most 3600; optional)
        velocity_m_s: Largest speed of the tool. (number in m/s, above 0, at most 1; default 0.25)
        turn_deg_s: Largest angular speed of the tool. (number in deg/s, above 0, at most 180; default 57.2958)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        """
    @operation
    def hold(
        self, seconds: float | None = ..., *, until: Until | None = ..., tool: str | None = ...,
        tcp: str | None = ..., compliance: Any | None = ..., abort_if: Until | None = ...
    ) -> Run:
        """Holds an arm where it is.

        seconds: Ends after this time. (number in s, at least 0, at most 3600; optional)
        until: Ends when this becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        """
    @operation
    def jog(
        self, while_: Until, *, seconds: float | None = ..., until: Until | None = ..., tool: str | None = ...,
        tcp: str | None = ..., compliance: Any | None = ..., abort_if: Until | None = ...,
        linear_max_m_s: float | None = ..., angular_max_deg_s: float | None = ..., in_: str | None = ...,
        channel: str | None = ..., linear_m_s: Numbers | None = ..., angular_deg_s: Numbers | None = ...
    ) -> Run:
        """Manual control with a dead-man switch.

        seconds: Ends after this time. (number in s, at least 0, at most 3600; optional)
        until: Ends when this becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        linear_max_m_s: Largest speed of the tool. (number in m/s, above 0, at most 1; default 0.1)
        angular_max_deg_s: Largest angular speed of the tool. (number in deg/s, above 0, at most 180; default 28.6479)
        in_: Frame along whose axes the velocity is; "tcp": those of the tool. (text; default world)
        channel: Channel of type Twist that gives the velocity. (text; optional)
        linear_m_s: Velocity of the tool centre point. (three numbers in m/s; optional)
        angular_deg_s: Angular velocity of the tool. (three numbers in deg/s; optional)
        while_: Dead-man switch: the arm moves only while this is true. (condition; required)
        """
    @operation
    def lin(
        self, to: Goal, *, tool: str | None = ..., tcp: str | None = ..., base_to: Goal | None = ...,
        speed: float | None = ..., acceleration: float | None = ..., velocity_m_s: float | None = ...,
        follower: str | None = ..., compliance: Any | None = ..., weave: Any | None = ...,
        force_offset: Any | None = ..., until: Until | None = ..., on_end: Literal["fail", "continue"] | None = ...,
        abort_if: Until | None = ..., blend_m: float | None = ..., blend_fraction: float | None = ...,
        blend: float | None = ..., X_FM: Array | None = ...
    ) -> Run:
        """Moves the tool centre point on a straight line; with 'base_to' the base that carries the arm drives meanwhile.

        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        to: Goal of the motion. (goal; required)
        base_to: Where the base that carries the arm drives meanwhile. (goal; optional)
        speed: Share of the velocity limits. (number, above 0, at most 1; default 1)
        acceleration: Share of the acceleration and jerk limits. (number, above 0, at most 1; default 1)
        velocity_m_s: Speed of the tool centre point. (number in m/s, above 0; optional)
        follower: Second arm that moves as one with this one. (name of an arm; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        weave: Oscillation across the path. (weave; optional)
        force_offset: Shift of the path that holds a force. (force_offset; optional)
        until: Guarded motion: brakes on its path when this becomes true. (condition; optional)
        on_end: Whether a guarded motion that reaches its goal fails. (fail, continue; default fail)
        abort_if: Brakes on its path and fails when this becomes true. (condition; optional)
        blend_m: Distance from the goal at which the next motion takes over. (number in m, at least 1e-05; optional)
        blend_fraction: The same as a share of the path. (number, at least 0.0001, at most 0.5; optional)
        blend: share of its time from which the next motion may take over, 0.5 to 1 (optional)
        X_FM: pose of the frame that moves, in the flange, 4x4 in m (optional)
        """
    @step
    def look_at(
        self, at: str, *, seconds: float | None = ..., until: Until | None = ..., tool: str | None = ...,
        tcp: str | None = ..., compliance: Any | None = ..., abort_if: Until | None = ...,
        linear_max_m_s: float | None = ..., angular_max_deg_s: float | None = ..., in_: str | None = ...,
        distance_m: float | None = ..., azimuth_deg: float | None = ..., elevation_deg: float | None = ...,
        roll_deg: float | None = ..., distance_channel: str | None = ..., azimuth_channel: str | None = ...,
        elevation_channel: str | None = ..., orbit_linear_max_m_s: float | None = ...,
        orbit_angular_max_deg_s: float | None = ..., on_unreachable: Literal["rest", "fail"] | None = ...
    ) -> None:
        """A camera on an arm keeps a frame in the middle of its picture, from a distance and at two angles.

        seconds: Ends after this time. (number in s, at least 0, at most 3600; optional)
        until: Ends when this becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        linear_max_m_s: Largest speed of the tool. (number in m/s, above 0, at most 1; default 0.25)
        angular_max_deg_s: Largest angular speed of the tool. (number in deg/s, above 0, at most 180; default 57.2958)
        at: Frame whose origin is kept in the middle of the picture. (text; required)
        in_: Frame whose z is up and from whose x the azimuth counts. (text; default world)
        distance_m: From the frame to the camera. (number in m, at least 0.05, at most 5; default 0.5)
        azimuth_deg: Of the camera, about z of 'in'. (number in deg, at least -360, at most 360; default 0)
        elevation_deg: Of the camera, above the x-y plane of 'in'. (number in deg, at least -90, at most 90; default
            30)
        roll_deg: Of the camera about its line of sight. (number in deg, at least -180, at most 180; default 0)
        distance_channel: Channel of type Real, in m, that gives the distance. (text; optional)
        azimuth_channel: Channel of type Real, in rad, that gives the azimuth. (text; optional)
        elevation_channel: Channel of type Real, in rad, that gives the elevation. (text; optional)
        orbit_linear_max_m_s: How fast the distance may change. (number in m/s, above 0, at most 1; default 0.1)
        orbit_angular_max_deg_s: How fast azimuth and elevation may change. (number in deg/s, above 0, at most 180;
            default 17.1887)
        on_unreachable: Whether it rests or fails where the arm cannot look from there. (rest, fail; default rest)
        """
    @operation
    def move(
        self, to: Goal, *, tool: str | None = ..., tcp: str | None = ..., speed: float | None = ...,
        acceleration: float | None = ..., velocity_m_s: float | None = ..., clearance_m: float | None = ...,
        seed: int | None = ..., effort: float | None = ..., compliance: Any | None = ..., until: Until | None = ...,
        on_end: Literal["fail", "continue"] | None = ..., abort_if: Until | None = ..., blend_m: float | None = ...,
        blend_fraction: float | None = ..., blend: float | None = ..., X_FM: Array | None = ...
    ) -> Run:
        """Moves all joints to a goal on a path around what is in the way.

        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        to: Goal of the motion. (goal; required)
        speed: Share of the velocity limits. (number, above 0, at most 1; default 1)
        acceleration: Share of the acceleration and jerk limits. (number, above 0, at most 1; default 1)
        velocity_m_s: Speed of the tool centre point. (number in m/s, above 0; optional)
        clearance_m: Distance kept beyond the margin of the cell, where start and goal allow it. (number in m, at
            least 0.0005, at most 0.1; default 0.004)
        seed: Of all that is random in the search: the same seed finds the same path. (whole number, at least 0, at
            most 1e+09; default 1)
        effort: How long a path is looked for; 1: 100 000 postures. (number, at least 0.01, at most 100; default 1)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        until: Guarded motion: brakes on its path when this becomes true. (condition; optional)
        on_end: Whether a guarded motion that reaches its goal fails. (fail, continue; default fail)
        abort_if: Brakes on its path and fails when this becomes true. (condition; optional)
        blend_m: Distance from the goal at which the next motion takes over. (number in m, at least 1e-05; optional)
        blend_fraction: The same as a share of the path. (number, at least 0.0001, at most 0.5; optional)
        blend: share of its time from which the next motion may take over, 0.5 to 1 (optional)
        X_FM: pose of the frame that moves, in the flange, 4x4 in m (optional)
        """
    @operation
    def press(
        self, sensor: str | None = ..., *, direction: Numbers | None = ..., in_: str | None = ...,
        force_N: float | None = ..., approach_m_s: float | None = ..., travel_m: float | None = ...,
        tolerance: float | None = ..., depth_max_m: float | None = ..., lateral_max_N: float | None = ...,
        until: Until | None = ..., tool: str | None = ..., tcp: str | None = ..., compliance: Any | None = ...,
        abort_if: Until | None = ..., seconds: float | None = ...
    ) -> Run:
        """Approaches along a direction until contact, then presses with a force.

        sensor: Force/torque sensor on that arm. (name of a force/torque sensor; default the only one of the cell)
        direction: Direction of the motion and of the force; any length but 0. (three numbers; default [0, 0, 1])
        in_: Frame whose axes the direction is along; "tcp": those of the tool. (text; default tcp)
        force_N: Force that the tool exerts. (number in N, at least 0.1, at most 1000; default 10)
        approach_m_s: Speed until contact. (number in m/s, above 0, at most 0.1; default 0.002)
        travel_m: Largest distance along the direction, from the start. (number in m, above 0, at most 2; default
            0.05)
        tolerance: Share of the force by which it may be off and still counts as reached. (number, at least 0.01, at
            most 0.5; default 0.1)
        depth_max_m: Largest distance beyond the touch, as measured; more is a failure. (number in m, above 0, at most
            2; optional)
        lateral_max_N: Largest force across the direction; more is a failure. (number in N, at least 0.1, at most
            1000; optional)
        until: Ends the operation when it becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        seconds: How long the force is held once it is reached; without 'until' 0.5 as a step, without end in a
            transaction. (number in s, at least 0, at most 3600; optional)
        """
    @operation
    def ptp(
        self, to: Goal, *, tool: str | None = ..., tcp: str | None = ..., speed: float | None = ...,
        acceleration: float | None = ..., solution: Literal["nearest", "free"] | None = ...,
        compliance: Any | None = ..., until: Until | None = ..., on_end: Literal["fail", "continue"] | None = ...,
        abort_if: Until | None = ..., blend_m: float | None = ..., blend_fraction: float | None = ...,
        blend: float | None = ..., X_FM: Array | None = ...
    ) -> Run:
        """Moves all joints together to a goal.

        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        to: Goal of the motion. (goal; required)
        speed: Share of the velocity limits. (number, above 0, at most 1; default 1)
        acceleration: Share of the acceleration and jerk limits. (number, above 0, at most 1; default 1)
        solution: Of several joint configurations with the pose: the nearest, or the nearest whose path is free.
            (nearest, free; default nearest)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        until: Guarded motion: brakes on its path when this becomes true. (condition; optional)
        on_end: Whether a guarded motion that reaches its goal fails. (fail, continue; default fail)
        abort_if: Brakes on its path and fails when this becomes true. (condition; optional)
        blend_m: Distance from the goal at which the next motion takes over. (number in m, at least 1e-05; optional)
        blend_fraction: The same as a share of the path. (number, at least 0.0001, at most 0.5; optional)
        blend: share of its time from which the next motion may take over, 0.5 to 1 (optional)
        X_FM: pose of the frame that moves, in the flange, 4x4 in m (optional)
        """
    @step
    def record_contact(self, as_: str) -> None:
        """Keeps the contact that the last guarded motion ended with.

        as_: Name under which the contact is kept. (text; required)
        """
    @operation
    def search(
        self, radius_m: float, pitch_m: float, *, sensor: str | None = ..., direction: Numbers | None = ...,
        in_: str | None = ..., force_N: float | None = ..., approach_m_s: float | None = ...,
        travel_m: float | None = ..., tolerance: float | None = ..., depth_max_m: float | None = ...,
        lateral_max_N: float | None = ..., until: Until | None = ..., tool: str | None = ..., tcp: str | None = ...,
        compliance: Any | None = ..., abort_if: Until | None = ..., pattern: Literal["spiral", "zigzag"] | None = ...,
        velocity_m_s: float | None = ..., drop_m: float | None = ..., on_end: Literal["fail", "continue"] | None = ...
    ) -> Run:
        """Presses and follows a pattern until something is found.

        sensor: Force/torque sensor on that arm. (name of a force/torque sensor; default the only one of the cell)
        direction: Direction of the motion and of the force; any length but 0. (three numbers; default [0, 0, 1])
        in_: Frame whose axes the direction is along; "tcp": those of the tool. (text; default tcp)
        force_N: Force that the tool exerts. (number in N, at least 0.1, at most 1000; default 10)
        approach_m_s: Speed until contact. (number in m/s, above 0, at most 0.1; default 0.002)
        travel_m: Largest distance along the direction, from the start. (number in m, above 0, at most 2; default
            0.05)
        tolerance: Share of the force by which it may be off and still counts as reached. (number, at least 0.01, at
            most 0.5; default 0.1)
        depth_max_m: Largest distance beyond the touch, as measured; more is a failure. (number in m, above 0, at most
            2; optional)
        lateral_max_N: Largest force across the direction; more is a failure. (number in N, at least 0.1, at most
            1000; optional)
        until: Ends the operation when it becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        pattern: Path across the direction. (spiral, zigzag; default spiral)
        radius_m: Radius of the spiral, half the side of the zigzag. (number in m, at least 0.0001, at most 1;
            required)
        pitch_m: Distance between neighbouring turns or lanes. (number in m, at least 1e-05, at most 1; required)
        velocity_m_s: Speed along the pattern. (number in m/s, above 0, at most 1; default 0.01)
        drop_m: Found: the tool is this much deeper than at contact. (number in m, above 0; optional)
        on_end: Whether a pattern that ends without a find fails the step. (fail, continue; default fail)
        """
    @operation
    def spline(
        self, through: Sequence[Goal], *, tool: str | None = ..., tcp: str | None = ..., speed: float | None = ...,
        acceleration: float | None = ..., velocity_m_s: float | None = ..., compliance: Any | None = ...,
        weave: Any | None = ..., force_offset: Any | None = ..., until: Until | None = ...,
        on_end: Literal["fail", "continue"] | None = ..., abort_if: Until | None = ..., blend_m: float | None = ...,
        blend_fraction: float | None = ..., blend: float | None = ..., X_FM: Array | None = ...
    ) -> Run:
        """Moves smoothly through points.

        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        through: Points of the spline: goals of one kind, 2 to 200. (through; required)
        speed: Share of the velocity limits. (number, above 0, at most 1; default 1)
        acceleration: Share of the acceleration and jerk limits. (number, above 0, at most 1; default 1)
        velocity_m_s: Speed of the tool centre point. (number in m/s, above 0; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        weave: Oscillation across the path. (weave; optional)
        force_offset: Shift of the path that holds a force. (force_offset; optional)
        until: Guarded motion: brakes on its path when this becomes true. (condition; optional)
        on_end: Whether a guarded motion that reaches its goal fails. (fail, continue; default fail)
        abort_if: Brakes on its path and fails when this becomes true. (condition; optional)
        blend_m: Distance from the goal at which the next motion takes over. (number in m, at least 1e-05; optional)
        blend_fraction: The same as a share of the path. (number, at least 0.0001, at most 0.5; optional)
        blend: share of its time from which the next motion may take over, 0.5 to 1 (optional)
        X_FM: pose of the frame that moves, in the flange, 4x4 in m (optional)
        """
    @operation
    def weld(
        self, workpiece: str, line: str, *, torch: str | None = ..., travel_m_s: float | None = ...,
        stick_out_m: float | None = ..., travel_angle_deg: float | None = ..., work_angle_deg: float | None = ...,
        rotation_deg: float | None = ..., blend_m: float | None = ..., weave: Any | None = ...,
        preflow_s: float | None = ..., ignition_timeout_s: float | None = ..., crater_s: float | None = ...,
        postflow_s: float | None = ..., overlap_m: float | None = ..., restarts: int | None = ...,
        approach_m_s: float | None = ..., retract_m: float | None = ..., abort_if: Until | None = ...,
        tool: str | None = ..., tcp: str | None = ...
    ) -> Run:
        """Welds along a line of a workpiece: gas, ignition, seam, crater, gas, as one command.

        torch: Device with the outputs gas, arc, wire and the input established. (text; default the only one of the
            cell)
        workpiece: Object with lines. (name of an object; required)
        line: Line of the workpiece. (text; required)
        travel_m_s: Speed along the line, which an override does not scale. (number in m/s, above 0, at most 0.2;
            default 0.008)
        stick_out_m: Distance of the tool centre point from the line, along z of the tool. (number in m, at least 0,
            at most 0.1; default 0.015)
        travel_angle_deg: Tilt in the direction of travel: above 0 the torch points ahead, below 0 back. (number in
            deg, at least -60, at most 60; default 0)
        work_angle_deg: Tilt across the direction of travel. (number in deg, at least -60, at most 60; default 0)
        rotation_deg: Turn about the axis of the torch; 0: x of the tool is along the beginning of the line. (number
            in deg, at least -360, at most 360; default 0)
        blend_m: Distance from a corner at which the next part of the line begins; 0: the torch stops there. (number
            in m, at least 0, at most 0.1; default 0.004)
        weave: Swing across the line. (weld_weave; optional)
        preflow_s: Time of gas before the ignition. (number in s, at least 0, at most 60; default 0.3)
        ignition_timeout_s: Within which the arc has to burn. (number in s, at least 0, at most 60; default 1)
        crater_s: Time of the arc at rest at the end. (number in s, at least 0, at most 60; default 0.3)
        postflow_s: Time of gas after the arc. (number in s, at least 0, at most 60; default 0.5)
        overlap_m: How far before the place where it went out the arc is lit again. (number in m, at least 0, at most
            0.1; default 0.005)
        restarts: How often an arc that was lost is lit again before the step fails. (whole number, at least 0, at
            most 100; default 0)
        approach_m_s: Speed to the line and away from it. (number in m/s, above 0, at most 1; default 0.1)
        retract_m: Distance along the torch, before the line and after it. (number in m, at least 0.001, at most 0.5;
            default 0.05)
        abort_if: Ends the seam in order and fails when this becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        """
    @operation
    def wipe(
        self, in_: str, *, sensor: str | None = ..., centre_m: Numbers | None = ..., length_m: float | None = ...,
        width_m: float | None = ..., pitch_m: float | None = ..., velocity_m_s: float | None = ...,
        force_N: float | None = ..., approach_m_s: float | None = ..., travel_m: float | None = ...,
        tolerance: float | None = ..., depth_max_m: float | None = ..., lateral_max_N: float | None = ...,
        until: Until | None = ..., tool: str | None = ..., tcp: str | None = ..., compliance: Any | None = ...,
        abort_if: Until | None = ...
    ) -> Run:
        """Follows a surface in lanes with a constant force.

        sensor: Force/torque sensor on that arm. (name of a force/torque sensor; default the only one of the cell)
        in_: Frame of the surface: the lanes are along its x, the force is against its z. (text; required)
        centre_m: Centre of the rectangle in that frame. (three numbers in m; default [0, 0, 0])
        length_m: Length of the lanes. (number in m, at least 0.001, at most 5; default 0.1)
        width_m: Extent of the rectangle across the lanes. (number in m, at least 0, at most 5; default 0.1)
        pitch_m: Largest distance between neighbouring lanes. (number in m, at least 0.0005, at most 1; default 0.02)
        velocity_m_s: Speed of the tool along the lanes. (number in m/s, above 0, at most 1; default 0.05)
        force_N: Force that the tool exerts. (number in N, at least 0.1, at most 1000; default 10)
        approach_m_s: Speed until contact. (number in m/s, above 0, at most 0.1; default 0.002)
        travel_m: Largest distance along the direction, from the start. (number in m, above 0, at most 2; default
            0.05)
        tolerance: Share of the force by which it may be off and still counts as reached. (number, at least 0.01, at
            most 0.5; default 0.1)
        depth_max_m: Largest distance beyond the touch, as measured; more is a failure. (number in m, above 0, at most
            2; optional)
        lateral_max_N: Largest force across the direction; more is a failure. (number in N, at least 0.1, at most
            1000; optional)
        until: Ends the operation when it becomes true. (condition; optional)
        tool: Tool of the arm that it works with: the one that the cell declares. (text; optional)
        tcp: Tool centre point of that tool, or a frame of what the arm holds: that of the tool. (text; optional)
        compliance: How the arm yields to forces meanwhile; the arm has to be in that control mode. (compliance;
            optional)
        abort_if: Comes to rest and fails when this becomes true. (condition; optional)
        """

class GripperOperations:
    @operation
    def grip(
        self, width_m: float | None = ..., *, speed_m_s: float | None = ..., force_N: float | None = ...,
        timeout_s: float | None = ..., expect: Literal["part", "nothing", "any"] | None = ..., part: str | None = ...,
        part_mass_kg: float | None = ...
    ) -> Run:
        """Closes a gripper until a part stops its fingers.

        width_m: Width to move to: 0 to close, the stroke to open. (number in m, at least 0; optional)
        speed_m_s: Speed of the fingers: a quarter of the fastest. (number in m/s, above 0; optional)
        force_N: Gripping force: half of the largest. (number in N, above 0; optional)
        timeout_s: The step fails if the fingers are not at rest by then: time for twice the stroke, and 1 s. (number
            in s, above 0, at most 3600; optional)
        expect: What has to be between the fingers at the end. (part, nothing, any; default part)
        part: Object that is gripped: the free object between the fingers. (name of an object; optional)
        part_mass_kg: Mass of the part, or this arm's share of it: checked against the object. (number in kg, at least
            0; default 0)
        """
    @operation
    def release(
        self, width_m: float | None = ..., *, speed_m_s: float | None = ..., force_N: float | None = ...,
        timeout_s: float | None = ..., onto: str | None = ...
    ) -> Run:
        """Opens a gripper.

        width_m: Width to move to: 0 to close, the stroke to open. (number in m, at least 0; optional)
        speed_m_s: Speed of the fingers: a quarter of the fastest. (number in m/s, above 0; optional)
        force_N: Gripping force: half of the largest. (number in N, above 0; optional)
        timeout_s: The step fails if the fingers are not at rest by then: time for twice the stroke, and 1 s. (number
            in s, above 0, at most 3600; optional)
        onto: What the part stands on then: a frame, an object, a base; found by shapes. (text; optional)
        """

class ToolChangerOperations:
    @operation
    def couple(self, timeout_s: float | None = ..., *, tool: str | None = ...) -> Run:
        """Locks a tool changer: what it couples is a tool of its arm from then on.

        tool: Tool side, or a tool on it, that has to be coupled: whatever is there. (text; optional)
        timeout_s: The step fails if the lock is open by then. (number in s, above 0, at most 60; default 2)
        """
    @operation
    def uncouple(self, onto: str | None = ..., *, timeout_s: float | None = ...) -> Run:
        """Unlocks a tool changer: its tool stays where it is.

        onto: Frame, object or base that the tool depends on then: the world. (text; optional)
        timeout_s: The step fails if the lock is closed by then. (number in s, above 0, at most 60; default 2)
        """

class OutputOperations:
    @operation
    def set(
        self, value: Any, *, factor: float | None = ..., offset: float | None = ..., seconds: float | None = ...,
        until: Until | None = ...
    ) -> Run:
        """Sets a digital or analog output, which keeps its value; or lets an analog output follow a value.

        value: Level, number in the unit of the output, or what an analog output follows. (output_value; required)
        factor: Of an output that follows: its value for each unit of the source. (number; optional)
        offset: Of an output that follows: added, in the unit of the output. (number; optional)
        seconds: How long the output follows. (number in s, at least 0, at most 3600; optional)
        until: The output follows until this becomes true. (condition; optional)
        """

class CellOperations:
    @step
    def attach(self, part: str | None = ..., *, tool: str | None = ..., grasp: str | None = ...) -> None:
        """Notes that a tool without fingers holds an object: a magnet, a suction cup.

        tool: Tool that holds the part: a device with a tool centre point. (text; default the only one of the cell)
        part: Object that the tool holds: the free object at its tool centre point. (name of an object; optional)
        grasp: Grasp of the object that is at the tool centre point: it is held as it is believed to be. (text;
            optional)
        """
    @step
    def detach(
        self, onto: str | None = ..., *, tool: str | None = ..., position_m: Numbers | None = ...,
        rpy_deg: Numbers | None = ...
    ) -> None:
        """Notes that a tool without fingers does not hold its object any more.

        tool: Tool that holds the part: a device with a tool centre point. (text; default the only one of the cell)
        onto: What the part stands on then: a frame, an object, a base; found by shapes. (text; optional)
        position_m: Where the part is then, in 'onto': where the tool has it. (three numbers in m; optional)
        rpy_deg: Its orientation then, in 'onto': roll, pitch, yaw. (three numbers in deg; optional)
        """
    @step
    def fit_pose(
        self, object: str, as_: str, contacts: Sequence[str], free: Sequence[str], *,
        max_residual_m: float | None = ...
    ) -> None:
        """Finds the pose of an object from recorded contacts.

        object: Object that was touched. (name of an object; required)
        as_: Name of the frame that gets the fitted pose. (text; required)
        contacts: Names of recorded contacts. (list of texts; required)
        free: Coordinates that are fitted: x, y, z, roll, pitch, yaw of the object. (list of texts; required)
        max_residual_m: Largest residual (rms) of a good fit. (number in m, above 0; default 0.001)
        """
    @step
    def net(
        self, net: str, *, cancel_after_s: float | None = ..., monitor_rate_Hz: float | None = ...,
        within_s: float | None = ...
    ) -> None:
        """Runs a net of the cell to its end.

        net: Net of the cell that runs. (name of an net; required)
        cancel_after_s: The net is cancelled after this time. (number in s, at least 0, at most 3600; optional)
        monitor_rate_Hz: How often its monitors are shown while it runs; they are at its end in any case. (number in
            Hz, above 0, at most 1000; optional)
        within_s: The step fails if the net has not ended by then. (number in s, at least 0, at most 3600; default 60)
        """
    @step
    def set_frame(
        self, as_: str, *, in_: str | None = ..., of: str | None = ..., position_m: Numbers | None = ...,
        rpy_deg: Numbers | None = ...
    ) -> None:
        """Makes a frame, on whatever it depends on from then on, moves one that a step has made, or says where an object has been found.

        as_: Name of the frame; of an object that is not fixed: it has been found there. (text; required)
        in_: Frame, object or base that it depends on from now on; an object stays on what it stands on. (text;
            default world)
        of: Frame from whose present pose it is counted. (text; default that of 'in')
        position_m: Position in that frame. (three numbers in m; default [0, 0, 0])
        rpy_deg: Orientation in that frame: roll, pitch, yaw. (three numbers in deg; default [0, 0, 0])
        """
    @step
    def tare(self, sensor: str | None = ..., *, cycles: int | None = ...) -> None:
        """Averages a force/torque sensor at rest and removes that offset from its later readings.

        sensor: Force/torque sensor, at rest and without contact. (name of a force/torque sensor; default the only one
            of the cell)
        cycles: Samples that are averaged. (whole number, at least 1, at most 100000; default 500)
        """
    @step
    def transaction(
        self, commands: Mapping[str, Any], *, on: Any | None = ..., raised: Sequence[str] | None = ...,
        capture: Any | None = ..., on_cancel: Any | None = ...
    ) -> None:
        """Runs commands in one real-time context, with handlers for events.

        commands: Commands by name: operations with 'start' and 'on'. (commands; required)
        on: Handlers of the transaction itself. (handlers; optional)
        raised: States that handlers may raise. (list of texts; optional)
        capture: Values that are kept under a name. (captures; optional)
        on_cancel: Whom a cancel reaches: forward (all), ignore, or names of commands. (on_cancel; default forward)
        """
    @step
    def wait(self, seconds: float | None = ..., *, until: Until | None = ..., timeout_s: float | None = ...) -> None:
        """Lets time pass, or waits until a condition becomes true.

        seconds: Time that passes. (number in s, at least 0, at most 3600; optional)
        until: Waits until this becomes true. (condition; optional)
        timeout_s: The step fails if 'until' is not true by then. (number in s, at least 0, at most 3600; optional)
        """
