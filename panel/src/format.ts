// Values of ports, in few characters.
import type { Entry } from "./frames";

export const NULL = "null";

export function short(entry: Pick<Entry, "type" | "value">): string {
  const { type, value } = entry;
  if (value === null) return NULL;
  if (typeof value === "string") return value;
  const numbers = value.map((one) => figure(one));
  switch (type) {
    case "Boolean":
      return value[0] ? "true" : "false";
    case "Integer":
      return String(value[0]);
    case "Real":
      return numbers[0] ?? "";
    case "Frame":
      return `${numbers.slice(0, 3).join(" ")} m`;
    case "Wrench":
      return `${numbers.slice(0, 3).join(" ")} N`;
    case "Twist":
      return `${numbers.slice(0, 3).join(" ")} m/s`;
    default:
      return numbers.length > 4 ? `${numbers.slice(0, 4).join(" ")} …` : numbers.join(" ");
  }
}

/** Three digits or so. */
export function figure(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1000 || size < 0.001
    ? value.toExponential(1)
    : value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
}

/** Names of the parts of a value, for plots. */
export function partsOf(type: Entry["type"], count: number): string[] {
  switch (type) {
    case "Vector":
      return ["x", "y", "z"];
    case "Rotation":
      return ["w", "x", "y", "z"];
    case "Frame":
      return ["x", "y", "z", "qw", "qx", "qy", "qz"];
    case "Twist":
      return ["vx", "vy", "vz", "wx", "wy", "wz"];
    case "Wrench":
      return ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"];
    case "Joints":
      return Array.from({ length: count }, (_, i) => `joint ${i + 1}`);
    default:
      return ["value"];
  }
}
