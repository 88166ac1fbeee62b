import { Signal } from "./signal";

/** The time that plots and time line share, s of the cell: which part is shown, and where the cursor is. */
export class TimeAxis {
  readonly changed = new Signal<void>();
  readonly cursorMoved = new Signal<number | null>();
  now = 0;
  span = 20;
  cursor: number | null = null;
  private heldAt: number | null = null;

  get held(): boolean {
    return this.heldAt !== null;
  }
  get to(): number {
    return this.heldAt ?? Math.max(this.now, this.span);
  }
  get from(): number {
    return this.to - this.span;
  }

  /** The cell's time has gone on, or back: then it is another cell. */
  advance(time_s: number): void {
    if (time_s < this.now - 1) this.heldAt = null;
    this.now = time_s;
    this.changed.emit();
  }

  hold(held: boolean): void {
    this.heldAt = held ? this.now : null;
    this.changed.emit();
  }

  show(span: number): void {
    this.span = span;
    this.changed.emit();
  }

  setCursor(time_s: number | null): void {
    if (time_s === this.cursor) return;
    this.cursor = time_s;
    this.cursorMoved.emit(time_s);
  }
}
