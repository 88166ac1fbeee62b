// Where the primitives of a net stand: in columns from left to right, along the links that act in the same cycle.
import type { Graph } from "./api";

export interface Box {
  x: number;
  y: number;
  column: number;
}
export const BOX = { width: 176, height: 60, gapX: 56, gapY: 20 };

export function layout(graph: Graph): { boxes: Box[]; width: number; height: number } {
  const links = graph.links.filter((link) => !link.delayed && link.from !== link.to);
  const column = graph.primitives.map(() => 0);
  // In the order of evaluation each primitive stands behind all that it reads.
  const order = graph.primitives
    .map((_, i) => i)
    .sort((a, b) => (graph.primitives[a]?.order ?? 0) - (graph.primitives[b]?.order ?? 0));
  for (const to of order)
    for (const link of links) if (link.to === to) column[to] = Math.max(column[to] ?? 0, (column[link.from] ?? 0) + 1);
  const rows = new Map<number, number[]>();
  order.forEach((i) => rows.set(column[i] ?? 0, [...(rows.get(column[i] ?? 0) ?? []), i]));
  const y = new Map<number, number>();
  // Each column is sorted by where its inputs stand: few links cross.
  for (const [, members] of [...rows].sort(([a], [b]) => a - b)) {
    const wish = (i: number): number => {
      const from = links.filter((link) => link.to === i).map((link) => y.get(link.from) ?? 0);
      return from.length ? from.reduce((a, b) => a + b, 0) / from.length : Infinity;
    };
    members.sort((a, b) => wish(a) - wish(b) || a - b).forEach((i, row) => y.set(i, row * (BOX.height + BOX.gapY)));
  }
  const boxes = graph.primitives.map((_, i) => ({
    x: (column[i] ?? 0) * (BOX.width + BOX.gapX),
    y: y.get(i) ?? 0,
    column: column[i] ?? 0,
  }));
  return {
    boxes,
    width: Math.max(0, ...boxes.map((box) => box.x)) + BOX.width,
    height: Math.max(0, ...boxes.map((box) => box.y)) + BOX.height,
  };
}
