// What the server answers (docs/remote.md), as far as the page reads it.
export interface Diagnostic {
  severity?: string;
  code?: string;
  pointer?: string;
  message?: string;
  hint?: string;
}
export interface Fault {
  device: string;
  cycle: number;
  time_s: number;
  cause: string;
  hint: string;
}
export interface State {
  cycle: number;
  time_s: number;
  digest: string;
  connected: boolean;
  realtime: boolean;
  holder: number;
  holder_name: string;
  title: string;
  reality: "SIM" | "EMULATED" | "HARDWARE";
  program: boolean;
  health: { overruns: number; worst_cycle_s: number };
  faults: Fault[];
}
export interface CellEvent {
  sequence: number;
  cycle: number;
  kind: "state" | "done" | "refused" | "stopped";
  net: number;
  request: number;
  cause: string;
  text: string;
  state?: string;
}
export interface NetState {
  net: number;
  name: string;
  state: string;
  cause: string;
  cause_text: string;
  first_cycle: number;
  last_cycle: number;
  diagnostics: Diagnostic[];
}
export interface Port {
  name: string;
  type: string;
}
export interface Primitive {
  id: string;
  type: string;
  order: number;
  inputs: Port[];
  outputs: Port[];
}
export interface GraphLink {
  from: number;
  from_port: number;
  to: number;
  to_port: number;
  delayed: boolean;
  may_be_null: boolean;
}
export interface Graph {
  net: number;
  name: string;
  resources: string[];
  primitives: Primitive[];
  links: GraphLink[];
}
export interface Reaction {
  source: string;
  sink: string;
  minimum_cycles: number;
  maximum_cycles: number;
  data_dependent: boolean;
  exact: boolean;
}
export interface Device {
  name: string;
  kind: string;
}
export interface Channel {
  name: string;
  type: string;
  unit?: string;
}
export interface Arm {
  name: string;
  state: {
    q_measured: number[];
    q_commanded: number[];
    mode: string;
    ready: boolean;
    at_rest: boolean;
    held: boolean;
    fault: number;
  };
  data_sheet: { joint_names: string[]; lower: number[]; upper: number[]; velocity: number[]; home: number[] };
}
/** [x, y, z, qw, qx, qy, qz], m. */
export type Pose = [number, number, number, number, number, number, number];
export interface Shape {
  kind: string;
  pose: Pose;
  rgba: [number, number, number, number];
  size: number[];
  radius: number;
  radii: number[];
  length: number;
  mesh: number;
}
export interface Body {
  name: string;
  parent: number;
  pose: Pose;
  shapes: Shape[];
}
export interface Scene {
  bodies: Body[];
  moving: number[];
  commanded: number[];
  meshes: { vertices: number; triangles: number; bytes: number }[];
  cameras: string[];
  frames: { name: string; pose: Pose; fixed: boolean }[];
  sensors: { name: string; arm: string; pose: Pose }[];
}
export interface Step {
  do: string;
  name: string;
  pointer: string;
  steps: Step[];
}
export interface Program {
  state: "awaits start" | "runs" | "paused" | "awaits step" | "ended";
  speed: number;
  steps: boolean;
  single: boolean;
  cancelled: boolean;
  next: { name: string; pointer: string; changed: string[] };
  planned_s: number;
  running: string[];
  verdict: string;
  findings: string[];
}
export interface LogEntry {
  sequence: number;
  time_s: number;
  cycle: number;
  level: "debug" | "info" | "warning" | "error";
  source: string;
  name: string;
  step: string;
  text: string;
}

/** An answer of the server that refuses something. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    detail: string,
    readonly diagnostics: Diagnostic[],
  ) {
    super(detail);
  }
  /** What is wrong and what to do, in one line. */
  get words(): string {
    const parts = this.diagnostics.map((one) => [one.message, one.hint].filter(Boolean).join(". "));
    return parts.length ? `${this.message}: ${parts.join("; ")}` : this.message;
  }
}
export const wordsOf = (error: unknown): string =>
  error instanceof Problem ? error.words : error instanceof Error ? error.message : String(error);
