// The cell in 3D: meshes once, poses as they come, drawn only when something has changed.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Json, Link } from "./link";
import type { Poses } from "./frames";

/** Directions from the middle of the cell to the camera. */
const VIEWS: Record<string, [number, number, number]> = { front: [1, 0, 0.3], left: [0, 1, 0.3], top: [0.001, 0, 1], corner: [1, -1, 0.6] };

export class View3d {
  readonly element = document.createElement("div");
  private readonly renderer = new THREE.WebGLRenderer({ antialias: true });
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(45, 1, 0.01, 100);
  private readonly controls = new OrbitControls(this.camera, this.renderer.domElement);
  private bodies: THREE.Group[] = [];
  private ghosts: THREE.Group[] = [];
  private moving: number[] = [];
  private names: string[] = [];
  private readonly trail = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xe8892b }));
  private readonly points: THREE.Vector3[] = [];
  private readonly told = document.createElement("output");
  private planned = false;
  private drawn = 0;

  constructor(private readonly link: Link) {
    this.element.className = "view3d";
    this.renderer.domElement.tabIndex = 0;
    this.renderer.domElement.setAttribute("role", "img");
    this.renderer.domElement.setAttribute("aria-label", "The cell in 3D: solid as measured, ghost as commanded");
    this.camera.up.set(0, 0, 1);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.listenToKeyEvents(this.renderer.domElement);
    const sun = new THREE.DirectionalLight(0xffffff, 2);
    sun.position.set(2, -1, 4);
    this.trail.frustumCulled = false;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x667080, 1.6), sun, this.trail);
    const bar = document.createElement("div");
    bar.className = "bar";
    for (const name of Object.keys(VIEWS)) bar.append(this.button(name, () => this.look(name)));
    bar.append(this.button("clear trail", () => { this.points.length = 0; this.trail.geometry.setFromPoints([]); this.draw(); }));
    this.told.textContent = "Click a body for its data";
    bar.append(this.told);
    this.element.append(bar, this.renderer.domElement);
    this.renderer.domElement.addEventListener("click", (event) => this.pick(event));
    new ResizeObserver(() => this.resize()).observe(this.element);
    new MutationObserver(() => this.theme()).observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    this.theme();
    this.look("corner");
  }

  /** Pictures drawn so far. */
  get pictures(): number { return this.drawn; }

  async load(): Promise<void> {
    const scene: Json = await this.link.ask("GET", "/v1/scene");
    const meshes = await Promise.all(scene.meshes.map(async (_: Json, i: number) => mesh(await this.link.ask("GET", `/v1/scene/meshes/${i}`))));
    for (const body of [...this.bodies, ...this.ghosts]) this.scene.remove(body);
    this.moving = scene.moving;
    this.names = scene.bodies.map((body: Json) => body.name);
    this.bodies = scene.bodies.map((body: Json) => group(body, meshes, false));
    this.ghosts = scene.commanded.map((index: number) => group(scene.bodies[index], meshes, true));
    this.bodies.forEach((body, index) => { body.userData.index = index; });
    this.scene.add(...this.bodies, ...this.ghosts);
    this.link.monitor({ poses: true }, Math.max(1, Math.round(0.033 / this.link.period_s)), () => {});
    this.look("corner");
  }

  show(poses: Poses): void {
    let changed = false;
    const set = (target: THREE.Object3D | undefined, list: Float32Array, i: number): void => {
      if (!target) return;
      const [x, y, z, w, a, b, c] = list.subarray(7 * i, 7 * i + 7);
      if (Math.hypot(target.position.x - x, target.position.y - y, target.position.z - z) < 1e-6 &&
          Math.abs(target.quaternion.x - a) + Math.abs(target.quaternion.y - b) + Math.abs(target.quaternion.z - c) < 1e-6) return;
      target.position.set(x, y, z);
      target.quaternion.set(a, b, c, w);
      changed = true;
    };
    this.moving.forEach((body, i) => set(this.bodies[body], poses.moving, i));
    this.ghosts.forEach((ghost, i) => set(ghost, poses.commanded, i));
    if (!changed) return;
    const tip = this.ghosts.length ? this.ghosts[this.ghosts.length - 1].position : null;
    if (tip && (this.points.length === 0 || tip.distanceTo(this.points[this.points.length - 1]) > 0.002)) {
      this.points.push(tip.clone());
      if (this.points.length > 4000) this.points.shift();
      this.trail.geometry.dispose();
      this.trail.geometry = new THREE.BufferGeometry().setFromPoints(this.points);
    }
    this.draw();
  }

  private button(text: string, act: () => void): HTMLButtonElement {
    const button = document.createElement("button");
    button.textContent = text;
    button.onclick = act;
    return button;
  }

  private look(name: string): void {
    const box = new THREE.Box3();
    for (const body of this.bodies.slice(1)) box.expandByObject(body); // the first is the world, with its floor
    const ball = box.isEmpty() ? new THREE.Sphere(new THREE.Vector3(0, 0, 0.5), 1) : box.getBoundingSphere(new THREE.Sphere());
    this.controls.target.copy(ball.center);
    this.camera.position.fromArray(VIEWS[name]).setLength(2.4 * ball.radius).add(ball.center);
    this.controls.update();
    this.draw();
  }

  private pick(event: MouseEvent): void {
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const hit = ray.intersectObjects(this.bodies)[0];
    let body: THREE.Object3D | null = hit?.object ?? null;
    while (body && body.userData.index === undefined) body = body.parent;
    this.told.textContent = body ? `${this.names[body.userData.index] || "world"}: ${body.position.toArray().map((v) => v.toFixed(3)).join(", ")} m` : "Nothing there";
  }

  private theme(): void {
    this.scene.background = new THREE.Color(document.documentElement.dataset.theme === "light" ? 0xe9edf1 : 0x1b2129);
    this.draw();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  private draw(): void {
    if (this.planned) return;
    this.planned = true;
    requestAnimationFrame(() => {
      this.planned = false;
      this.renderer.render(this.scene, this.camera);
      ++this.drawn;
    });
  }
}

function mesh(bytes: ArrayBuffer): THREE.BufferGeometry {
  const [vertices, triangles] = new Uint32Array(bytes, 0, 2);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytes, 8, 3 * vertices), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes, 8 + 12 * vertices, 3 * triangles), 1));
  geometry.computeVertexNormals();
  return geometry;
}

function place(object: THREE.Object3D, pose: number[]): void {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

function group(body: Json, meshes: THREE.BufferGeometry[], ghost: boolean): THREE.Group {
  const made = new THREE.Group();
  place(made, body.pose);
  for (const shape of body.shapes) {
    const solid = new THREE.Mesh(geometryOf(shape, meshes), material(shape.rgba, ghost));
    const holder = new THREE.Group();
    place(holder, shape.pose);
    if (shape.kind === "cylinder" || shape.kind === "capsule") solid.rotation.x = Math.PI / 2;
    if (shape.kind === "ellipsoid") solid.scale.fromArray(shape.radii);
    holder.add(solid);
    made.add(holder);
  }
  return made;
}

function material([r, g, b, opacity]: number[], ghost: boolean): THREE.Material {
  if (ghost) return new THREE.MeshBasicMaterial({ color: 0x2f9bff, transparent: true, opacity: 0.14, depthWrite: false });
  const color = new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace);
  return new THREE.MeshStandardMaterial({ color, roughness: 0.7, transparent: opacity < 1, opacity });
}

function geometryOf(shape: Json, meshes: THREE.BufferGeometry[]): THREE.BufferGeometry {
  switch (shape.kind) {
    case "box": return new THREE.BoxGeometry(...(shape.size as [number, number, number]));
    case "sphere": return new THREE.SphereGeometry(shape.radius, 24, 16);
    case "ellipsoid": return new THREE.SphereGeometry(1, 24, 16);
    case "cylinder": return new THREE.CylinderGeometry(shape.radius, shape.radius, shape.length, 24);
    case "capsule": return new THREE.CapsuleGeometry(shape.radius, shape.length, 8, 16);
    case "mesh": return meshes[shape.mesh];
    case "plane": return new THREE.PlaneGeometry(shape.size[0] || 20, shape.size[1] || 20);
    default: throw new Error(`the scene has a shape of unknown kind '${shape.kind}'`);
  }
}
