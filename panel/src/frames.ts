// Binary frames of takt.v1 (docs/remote.md, "Streams"): little-endian, every part at a multiple of 8 bytes.
export const TYPES = [
  "Boolean",
  "Integer",
  "Real",
  "String",
  "Vector",
  "Rotation",
  "Frame",
  "Twist",
  "Wrench",
  "Joints",
] as const;
export interface Entry {
  id: number;
  type: (typeof TYPES)[number];
  cycle: number;
  value: number[] | string | null;
}
export interface Values {
  kind: "values";
  frame: number;
  cycle: number;
  entries: Entry[];
}
export interface Poses {
  kind: "poses";
  frame: number;
  cycle: number;
  time_s: number;
  moving: Float32Array;
  commanded: Float32Array;
}

/** What a camera saw; `cycle` is that of the state in it. */
export interface Picture {
  kind: "picture";
  frame: number;
  cycle: number;
  time_s: number;
  id: number;
  png: Uint8Array<ArrayBuffer>;
}

/** Throws RangeError when the frame is shorter than it says, and Error when its kind or version is unknown. */
export function decode(buffer: ArrayBuffer): Values | Poses | Picture {
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  const version = view.getUint8(1);
  if (version !== 1) throw new Error(`frame of version ${version}; this page reads version 1`);
  const frame = view.getUint32(4, true);
  const cycle = Number(view.getBigInt64(8, true));
  if (kind === 2) {
    const moving = view.getUint32(24, true) * 7;
    const commanded = view.getUint32(28, true) * 7;
    return {
      kind: "poses",
      frame,
      cycle,
      time_s: view.getFloat64(16, true),
      moving: new Float32Array(buffer, 32, moving),
      commanded: new Float32Array(buffer, 32 + 4 * moving, commanded),
    };
  }
  if (kind === 3)
    return {
      kind: "picture",
      frame,
      cycle,
      time_s: view.getFloat64(16, true),
      id: view.getUint32(24, true),
      png: new Uint8Array(buffer, 40, view.getUint32(32, true)),
    };
  if (kind !== 1) throw new Error(`frame of unknown kind ${kind}`);
  const entries: Entry[] = [];
  let at = 16;
  for (let left = view.getUint16(2, true); left > 0; --left) {
    const id = view.getUint32(at, true);
    const type = TYPES[view.getUint8(at + 4)];
    if (type === undefined) throw new Error(`value of unknown type ${view.getUint8(at + 4)}`);
    const isNull = view.getUint8(at + 5) === 1;
    const bytes = view.getUint16(at + 6, true);
    const valueCycle = Number(view.getBigInt64(at + 8, true));
    at += 16;
    let value: Entry["value"] = null;
    if (!isNull) {
      if (type === "String") value = new TextDecoder().decode(new Uint8Array(buffer, at, bytes));
      else if (type === "Integer") value = [Number(view.getBigInt64(at, true))];
      else value = Array.from({ length: bytes / 8 }, (_, i) => view.getFloat64(at + 8 * i, true));
      at += Math.ceil(bytes / 8) * 8;
    }
    entries.push({ id, type, cycle: valueCycle, value });
  }
  return { kind: "values", frame, cycle, entries };
}
