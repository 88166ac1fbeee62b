// Objects of three.js from the scene of the server.
import * as THREE from "three";
import type { Body, Pose, Shape } from "./api";

export const GHOST = 0x2f9bff;

/** The mesh in the server's bytes: u32 vertices, u32 triangles, f32 positions, u32 corners. */
export function mesh(bytes: ArrayBuffer): THREE.BufferGeometry {
  const [vertices = 0, triangles = 0] = new Uint32Array(bytes, 0, 2);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytes, 8, 3 * vertices), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes, 8 + 12 * vertices, 3 * triangles), 1));
  // Corners that lie in one place and not in one plane get normals of their own, or edges would look melted.
  const flat = geometry.toNonIndexed();
  flat.computeVertexNormals();
  geometry.dispose();
  return flat;
}

export function place(object: THREE.Object3D, pose: Pose): void {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

/** A body with its shapes; a ghost is one colour and hides nothing. */
export function group(body: Body, meshes: THREE.BufferGeometry[], ghost: boolean): THREE.Group {
  const made = new THREE.Group();
  place(made, body.pose);
  for (const shape of body.shapes) {
    if (ghost && shape.rgba[3] < 1) continue;
    const solid = new THREE.Mesh(geometryOf(shape, meshes), material(shape.rgba, ghost));
    const holder = new THREE.Group();
    place(holder, shape.pose);
    if (shape.kind === "cylinder" || shape.kind === "capsule") solid.rotation.x = Math.PI / 2;
    if (shape.kind === "ellipsoid") solid.scale.fromArray(shape.radii);
    if (shape.kind === "plane") solid.name = "floor";
    holder.add(solid);
    made.add(holder);
  }
  return made;
}

function material([r, g, b, opacity]: Shape["rgba"], ghost: boolean): THREE.Material {
  if (ghost) return new THREE.MeshBasicMaterial({ color: GHOST, transparent: true, opacity: 0.3, depthWrite: false });
  const color = new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace);
  return new THREE.MeshLambertMaterial({ color, transparent: opacity < 1, opacity });
}

function geometryOf(shape: Shape, meshes: THREE.BufferGeometry[]): THREE.BufferGeometry {
  switch (shape.kind) {
    case "box":
      return new THREE.BoxGeometry(shape.size[0], shape.size[1], shape.size[2]);
    case "sphere":
      return new THREE.SphereGeometry(shape.radius, 24, 16);
    case "ellipsoid":
      return new THREE.SphereGeometry(1, 24, 16);
    case "cylinder":
      return new THREE.CylinderGeometry(shape.radius, shape.radius, shape.length, 32);
    case "capsule":
      return new THREE.CapsuleGeometry(shape.radius, shape.length, 8, 16);
    case "plane":
      return new THREE.PlaneGeometry(shape.size[0] || 20, shape.size[1] || 20);
    case "mesh": {
      const found = meshes[shape.mesh];
      if (found) return found;
    }
  }
  throw new Error(`the scene has a shape of unknown kind '${shape.kind}'`);
}
