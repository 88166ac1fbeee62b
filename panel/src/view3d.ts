// The cell in 3D: meshes once, poses as they come, drawn only when something has changed.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Scene } from "./api";
import { h, setText } from "./dom";
import type { Poses } from "./frames";
import type { Link } from "./link";
import { Pacer } from "./pacer";
import { group, mesh, place } from "./scene";
import { Trail } from "./trail";

/** Directions from the middle of the cell to the camera. */
const VIEWS: Record<string, [number, number, number]> = {
  corner: [1, -1, 0.55],
  front: [1, 0, 0.25],
  left: [0, 1, 0.25],
  top: [0.001, 0, 1],
};
const POSES_EVERY_S = 0.033;
const FORCES_EVERY_S = 0.05;
const METRES_PER_NEWTON = 0.01;
const LEAST_FORCE_N = 0.5;
const LEAST_CHANGE_N = 0.5;
/** Less nobody sees: what encoders add to an arm at rest is no reason to draw. */
const SEEN_M = 5e-5;
const SEEN_TURN = 1e-4;
const FARTHEST_GHOST_M = 0.0005;

export interface PictureColors {
  background: string;
  floor: string;
  line: string;
}
interface Sensor {
  body: THREE.Object3D;
  rotation: THREE.Quaternion;
  arrow: THREE.ArrowHelper;
  shown: THREE.Vector3;
}

export class View3d {
  readonly element = h("div", { class: "view3d" });
  private readonly renderer = new THREE.WebGLRenderer({ antialias: !drawsInSoftware(), powerPreference: "low-power" });
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(38, 1, 0.01, 100);
  private readonly controls = new OrbitControls(this.camera, this.renderer.domElement);
  private readonly frames = new THREE.Group();
  private readonly trails = new Map<number, Trail>();
  private readonly picked = h("output", { class: "picked" });
  private readonly floor = new THREE.MeshBasicMaterial();
  private readonly grid = new THREE.GridHelper(8, 16, 0xffffff, 0xffffff);
  private readonly mark = new THREE.BoxHelper(new THREE.Object3D(), 0xffb454);
  private bodies: THREE.Group[] = [];
  private ghosts: THREE.Group[] = [];
  private names: string[] = [];
  private moving: number[] = [];
  private commanded: number[] = [];
  private chosen = -1;
  private stop: (() => void)[] = [];
  private pixels = 1;
  private readonly pacer = new Pacer(
    this.renderer.getContext() as WebGL2RenderingContext,
    () => this.renderer.render(this.scene, this.camera),
    (share) => {
      this.pixels = share;
      this.fit();
    },
  );

  constructor(private readonly link: Link) {
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute(
      "aria-label",
      "The cell in 3D: solid as measured, blue as commanded where that differs. Arrow keys move the view.",
    );
    this.camera.up.set(0, 0, 1);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.listenToKeyEvents(canvas);
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(2, -1, 4);
    this.frames.visible = false;
    this.mark.visible = false;
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = 0.002;
    this.grid.material.vertexColors = false;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a93a0, 1.9), sun, this.grid, this.frames, this.mark);
    this.element.append(canvas, this.toolbar(), this.picked);
    canvas.addEventListener("click", (event) => this.pick(event));
    new ResizeObserver(() => this.resize()).observe(this.element);
    link.poses.on((poses) => this.show(poses));
  }

  /** Pictures drawn so far. */
  get pictures(): number {
    return this.pacer.pictures;
  }

  /** Fetches the scene anew, in place of what is shown. */
  async load(): Promise<Scene> {
    const scene = await this.link.ask<Scene>("GET", "/v1/scene");
    const meshes = await Promise.all(
      scene.meshes.map(async (_, i) => mesh(await this.link.bytes(`/v1/scene/meshes/${i}`))),
    );
    this.clear();
    this.moving = scene.moving;
    this.commanded = scene.commanded;
    this.names = scene.bodies.map((body) => body.name);
    this.bodies = scene.bodies.map((body) => group(body, meshes, false));
    this.bodies.forEach((body, index) => {
      body.userData["index"] = index;
    });
    this.ghosts = scene.commanded
      .flatMap((index) => scene.bodies[index] ?? [])
      .map((body) => group(body, meshes, true));
    for (const ghost of this.ghosts) ghost.visible = false;
    this.scene.add(...this.bodies, ...this.ghosts);
    this.layFloor();
    this.addFrames(scene);
    this.addTrails(scene);
    this.addSensors(scene);
    this.stop.push(this.link.monitor({ poses: true }, POSES_EVERY_S, () => {}));
    this.look("corner");
    return scene;
  }

  /** The colours of the page have changed. */
  theme(colors: PictureColors): void {
    this.scene.background = new THREE.Color(colors.background);
    this.floor.color.set(colors.floor);
    this.grid.material.color.set(colors.line);
    this.draw();
  }

  /** Planes of the cell look like the page, with lines every half metre, so that the cell stands out. */
  private layFloor(): void {
    let isThere = false;
    for (const body of this.bodies)
      body.traverse((part) => {
        if (!(part instanceof THREE.Mesh) || part.name !== "floor") return;
        part.material = this.floor;
        isThere = true;
      });
    this.grid.visible = isThere;
  }

  private clear(): void {
    for (const end of this.stop.splice(0)) end();
    this.scene.remove(...this.bodies, ...this.ghosts, ...[...this.trails.values()].map((trail) => trail.line));
    this.trails.clear();
    this.frames.clear();
    this.choose(-1);
  }

  private addFrames(scene: Scene): void {
    for (const frame of scene.frames) {
      if (!frame.fixed) continue;
      const axes = new THREE.AxesHelper(0.1);
      place(axes, frame.pose);
      this.frames.add(axes);
    }
  }

  /** One for each chain, at its last body, or where it branches into equals (fingers). */
  private addTrails(scene: Scene): void {
    const children = (body: number): number[] => this.commanded.filter((other) => scene.bodies[other]?.parent === body);
    const depth = (body: number): number => 1 + Math.max(0, ...children(body).map(depth));
    const longest = (body: number): number | undefined => {
      const [first, second] = children(body).sort((a, b) => depth(b) - depth(a));
      return first === undefined || (second !== undefined && depth(second) === depth(first)) ? undefined : first;
    };
    const roots = this.commanded.filter((body) => !this.commanded.includes(scene.bodies[body]?.parent ?? -1));
    for (const root of roots) {
      let end = root;
      for (let next = longest(end); next !== undefined; next = longest(end)) end = next;
      const trail = new Trail();
      this.trails.set(this.commanded.indexOf(end), trail);
      this.scene.add(trail.line);
    }
  }

  private addSensors(scene: Scene): void {
    for (const sensor of scene.sensors) {
      const own = this.bodies[this.names.indexOf(`${sensor.name}/measuring`)];
      const body = own ?? this.bodies[this.names.indexOf(`${sensor.arm}/flange`)];
      if (!body) continue;
      const [, , , w, x, y, z] = sensor.pose;
      const one: Sensor = {
        body,
        rotation: own ? new THREE.Quaternion() : new THREE.Quaternion(x, y, z, w),
        arrow: new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), undefined, 0.1, 0xffb454, 0.03, 0.02),
        shown: new THREE.Vector3(),
      };
      one.arrow.visible = false;
      this.scene.add(one.arrow);
      const end = this.link.monitor({ sensor: sensor.name }, FORCES_EVERY_S, ({ value }) => this.showForce(one, value));
      this.stop.push(() => {
        end();
        this.scene.remove(one.arrow);
      });
    }
  }

  private showForce(sensor: Sensor, value: number[] | string | null): void {
    const { body, rotation, arrow } = sensor;
    const force = Array.isArray(value) ? new THREE.Vector3(value[0], value[1], value[2]) : new THREE.Vector3();
    // Noise is no reason to draw.
    if (force.distanceTo(sensor.shown) < LEAST_CHANGE_N && body.position.equals(arrow.position)) return;
    sensor.shown.copy(force);
    const length = force.length();
    arrow.visible = length > LEAST_FORCE_N;
    arrow.position.copy(body.position);
    arrow.setDirection(force.normalize().applyQuaternion(rotation).applyQuaternion(body.quaternion));
    arrow.setLength(Math.max(0.001, Math.min(0.5, length * METRES_PER_NEWTON)), 0.03, 0.02);
    this.draw();
  }

  private show(poses: Poses): void {
    let changed = false;
    this.moving.forEach((body, i) => {
      changed = set(this.bodies[body], poses.moving, i) || changed;
    });
    this.ghosts.forEach((ghost, i) => {
      changed = set(ghost, poses.commanded, i) || changed;
    });
    if (!changed) return;
    this.ghosts.forEach((ghost, i) => {
      const solid = this.bodies[this.commanded[i] ?? -1];
      if (!solid) return;
      const error = ghost.position.distanceTo(solid.position);
      // Where both agree a ghost would only dull the picture.
      ghost.visible = error > FARTHEST_GHOST_M || ghost.quaternion.angleTo(solid.quaternion) > 0.01;
      this.trails.get(i)?.add(solid.position, error);
    });
    if (this.chosen >= 0) this.tell();
    this.draw();
  }

  private toolbar(): HTMLElement {
    const views = Object.keys(VIEWS).map((name) => h("button", { type: "button", click: () => this.look(name) }, name));
    const frames = h(
      "button",
      {
        type: "button",
        "aria-pressed": "false",
        click: () => {
          this.frames.visible = !this.frames.visible;
          frames.setAttribute("aria-pressed", String(this.frames.visible));
          this.draw();
        },
      },
      "frames",
    );
    const trail = h(
      "button",
      {
        type: "button",
        click: () => {
          for (const one of this.trails.values()) one.clear();
          this.draw();
        },
      },
      "clear trail",
    );
    return h("div", { class: "viewbar", role: "toolbar", "aria-label": "3D view" }, ...views, frames, trail);
  }

  private look(name: string): void {
    const box = new THREE.Box3();
    for (const body of this.bodies.slice(1)) box.expandByObject(body); // the first is the world, with its floor
    const ball = box.isEmpty()
      ? new THREE.Sphere(new THREE.Vector3(0, 0, 0.5), 1)
      : box.getBoundingSphere(new THREE.Sphere());
    const fit = ball.radius / Math.sin((this.camera.fov / 2) * (Math.PI / 180)) / Math.min(1, this.camera.aspect);
    this.controls.target.copy(ball.center);
    this.camera.position
      .fromArray(VIEWS[name] ?? [1, 0, 0])
      .setLength(0.95 * fit)
      .add(ball.center);
    this.controls.update();
    this.draw();
  }

  private pick(event: MouseEvent): void {
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    let body: THREE.Object3D | null = ray.intersectObjects(this.bodies)[0]?.object ?? null;
    while (body && body.userData["index"] === undefined) body = body.parent;
    this.choose((body?.userData["index"] as number | undefined) ?? -1);
  }

  private choose(index: number): void {
    this.chosen = index > 0 ? index : -1;
    this.mark.visible = this.chosen > 0;
    if (this.chosen > 0) this.tell();
    else setText(this.picked, "");
    this.draw();
  }

  private tell(): void {
    const body = this.bodies[this.chosen];
    if (!body) return;
    this.mark.setFromObject(body);
    const turn = new THREE.Euler().setFromQuaternion(body.quaternion, "ZYX");
    const degrees = [turn.x, turn.y, turn.z].map((angle) => ((angle * 180) / Math.PI).toFixed(1));
    setText(
      this.picked,
      `${this.names[this.chosen]}: ${body.position
        .toArray()
        .map((v) => v.toFixed(3))
        .join(", ")} m; rpy ${degrees.join(", ")}°`,
    );
  }

  private resize(): void {
    this.fit();
    this.draw();
  }

  private fit(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.pixels * Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  private draw(): void {
    this.pacer.ask();
  }
}

/** Without a graphics card each sample of a pixel costs the processor, which has the cell to run. */
function drawsInSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(context?.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

/** Takes pose i of a list. @return whether that is another one */
function set(target: THREE.Object3D | undefined, list: Float32Array, i: number): boolean {
  if (!target) return false;
  const [x = 0, y = 0, z = 0, w = 1, a = 0, b = 0, c = 0] = list.subarray(7 * i, 7 * i + 7);
  const { position: p, quaternion: q } = target;
  const turned = Math.abs(q.w - w) + Math.abs(q.x - a) + Math.abs(q.y - b) + Math.abs(q.z - c);
  if (Math.hypot(p.x - x, p.y - y, p.z - z) < SEEN_M && turned < SEEN_TURN) return false;
  p.set(x, y, z);
  q.set(a, b, c, w);
  return true;
}
