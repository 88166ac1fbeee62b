// What a camera of the cell sees, with the age of the picture. Pictures are fetched only while somebody looks.
import { Problem, wordsOf, type Scene } from "./api";
import { choice, h, setText } from "./dom";
import type { Link } from "./link";

const PAUSE_MS = 200;
const BUSY = 429; // another picture is being drawn

export class Cameras {
  readonly panel = h("div", { class: "cameras" });
  private readonly picture = h("img", { alt: "" });
  private readonly age = h("output", { class: "age" });
  private readonly select: HTMLSelectElement;
  private taken = 0;
  private shown = false;
  private url = "";

  constructor(private readonly link: Link) {
    const { label, select } = choice("Camera", [], () => {});
    this.select = select;
    this.panel.append(label, h("figure", {}, this.picture, h("figcaption", {}, this.age)));
    setInterval(() => this.tellAge(), 100);
  }

  load(scene: Scene): void {
    const names = [...new Set([...scene.cameras, "overview"])];
    this.select.replaceChildren(...names.map((name) => h("option", { value: name }, name)));
  }

  /** The tab is opened or left. */
  show(visible: boolean): void {
    const begins = visible && !this.shown;
    this.shown = visible;
    if (begins) void this.look();
  }

  private async look(): Promise<void> {
    while (this.shown) {
      if (this.link.open && this.select.value && !document.hidden) await this.fetch(this.select.value);
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
  }

  private async fetch(camera: string): Promise<void> {
    const asked = performance.now();
    try {
      const bytes = await this.link.bytes(`/v1/cameras/${encodeURIComponent(camera)}/picture?width=640&height=400`);
      const url = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
      this.picture.src = url;
      this.picture.alt = `What '${camera}' sees`;
      await this.picture.decode();
      URL.revokeObjectURL(this.url);
      this.url = url;
      this.taken = asked;
    } catch (error) {
      if (!(error instanceof Problem && error.status === BUSY)) setText(this.age, wordsOf(error));
    }
  }

  private tellAge(): void {
    if (!this.shown || this.taken === 0) return;
    const age = (performance.now() - this.taken) / 1000;
    setText(this.age, `${age.toFixed(1)} s old`);
    this.age.toggleAttribute("data-bad", age > 2);
  }
}
