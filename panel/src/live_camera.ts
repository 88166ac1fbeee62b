// What a camera of the cell sees, all the time while somebody looks at it, with the age of the picture.
import { h, setText } from "./dom";
import type { Picture } from "./frames";
import type { Link } from "./link";

const EVERY_S = 0.04;
const OLD_S = 0.5;

export class LiveCamera {
  private readonly canvas = h("canvas", { width: 320, height: 240, role: "img" });
  private readonly age = h("output", { class: "age" });
  readonly element = h("figure", { class: "live" }, this.canvas, h("figcaption", {}, this.age));
  private readonly context = this.canvas.getContext("2d");
  private end: (() => void) | null = null;
  private newest: Picture | null = null;
  private waiting: Picture | null = null;
  private decoding = false;
  /** Between two pictures, ms, smoothed; 0: not known yet. */
  private pause = 0;
  private lastAt = 0;
  private now_s = 0;

  constructor(private readonly link: Link) {
    link.poses.on((poses) => {
      this.now_s = poses.time_s;
    });
    setInterval(() => this.tellAge(), 100);
  }

  /** @param camera  empty: nobody looks */
  watch(camera: string, width = 320, height = 240): void {
    this.end?.();
    this.end = null;
    this.newest = null;
    this.pause = 0;
    if (!camera) return;
    [this.canvas.width, this.canvas.height] = [width, height];
    this.canvas.setAttribute("aria-label", `What '${camera}' sees`);
    setText(this.age, "no picture yet");
    this.end = this.link.watchCamera(
      { camera, width, height },
      EVERY_S,
      (picture) => this.take(picture),
      (why) => setText(this.age, why),
    );
  }

  /** The newest one counts: while one is decoded, those that come meanwhile replace each other. */
  private take(picture: Picture): void {
    this.waiting = picture;
    if (!this.decoding) void this.draw();
  }

  private async draw(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const picture = this.waiting;
      this.waiting = null;
      try {
        const bitmap = await createImageBitmap(new Blob([picture.png], { type: "image/png" }));
        this.context?.drawImage(bitmap, 0, 0);
        bitmap.close();
        this.shown(picture);
      } catch {
        setText(this.age, "the picture cannot be read");
      }
    }
    this.decoding = false;
  }

  private shown(picture: Picture): void {
    const at = performance.now();
    if (this.newest) this.pause += (this.pause > 0 ? 0.1 : 1) * (at - this.lastAt - this.pause);
    this.lastAt = at;
    this.newest = picture;
    this.now_s = Math.max(this.now_s, picture.time_s);
  }

  /** Of the state in the picture, as the cell's clock goes on: by itself where nothing is heard of it any more. */
  private tellAge(): void {
    if (!this.newest || !this.end) return;
    const silent = (performance.now() - this.lastAt) / 1000;
    const age = Math.max(this.now_s - this.newest.time_s, silent > OLD_S ? silent : 0);
    setText(
      this.age,
      `${Math.round(1000 * age)} ms old, ${this.pause > 0 ? Math.round(1000 / this.pause) : 0} pictures a second`,
    );
    this.age.toggleAttribute("data-bad", age > OLD_S);
    this.element.toggleAttribute("data-old", age > OLD_S);
  }
}
