// What a camera of the cell sees. Pictures come only while somebody looks.
import type { Scene } from "./api";
import { choice, h } from "./dom";
import type { Link } from "./link";
import { LiveCamera } from "./live_camera";

const [WIDTH, HEIGHT] = [480, 300];

export class Cameras {
  readonly panel = h("div", { class: "cameras" });
  private readonly live: LiveCamera;
  private readonly select: HTMLSelectElement;
  private shown = false;

  constructor(link: Link) {
    this.live = new LiveCamera(link);
    const { label, select } = choice("Camera", [], () => this.look());
    this.select = select;
    this.panel.append(label, this.live.element);
  }

  load(scene: Scene): void {
    const names = [...new Set([...scene.cameras, "overview"])];
    this.select.replaceChildren(...names.map((name) => h("option", { value: name }, name)));
    this.look();
  }

  /** The tab is opened or left. */
  show(visible: boolean): void {
    this.shown = visible;
    this.look();
  }

  private look(): void {
    this.live.watch(this.shown ? this.select.value : "", WIDTH, HEIGHT);
  }
}
