import * as THREE from "three";

const MOST_POINTS = 4000;
const STEP_M = 0.002;
const WORST_M = 0.005;
const GOOD = new THREE.Color(0x2fb39a);
const BAD = new THREE.Color(0xe5484d);

/** Where a body has been; its colour tells how far it was from where it was to be: green to red at 5 mm. */
export class Trail {
  readonly line: THREE.Line;
  private readonly points = new Float32Array(3 * MOST_POINTS);
  private readonly colors = new Float32Array(3 * MOST_POINTS);
  private readonly last = new THREE.Vector3(Infinity, 0, 0);
  private count = 0;

  constructor() {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.points, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(this.colors, 3));
    this.line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ vertexColors: true }));
    this.line.frustumCulled = false;
    this.clear();
  }

  clear(): void {
    this.count = 0;
    this.last.set(Infinity, 0, 0);
    this.line.geometry.setDrawRange(0, 0);
  }

  add(point: THREE.Vector3, error_m: number): void {
    if (point.distanceTo(this.last) < STEP_M) return;
    if (this.count === MOST_POINTS) {
      // Half of it is forgotten at once: cheaper than moving all of it for each point.
      this.points.copyWithin(0, (3 * MOST_POINTS) / 2);
      this.colors.copyWithin(0, (3 * MOST_POINTS) / 2);
      this.count = MOST_POINTS / 2;
    }
    this.last.copy(point);
    point.toArray(this.points, 3 * this.count);
    GOOD.clone()
      .lerp(BAD, Math.min(1, error_m / WORST_M))
      .toArray(this.colors, 3 * this.count);
    ++this.count;
    const { position, color } = this.line.geometry.attributes;
    if (position) position.needsUpdate = true;
    if (color) color.needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.count);
  }
}
