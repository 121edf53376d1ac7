// The arm in three dimensions, drawn by three.js on one canvas; asked for only when it is looked at.
import {
  BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, DirectionalLight, GridHelper, Group,
  HemisphereLight, Line, LineBasicMaterial, Mesh, MeshLambertMaterial, OrbitControls, PerspectiveCamera, Quaternion,
  Scene, Vector3, WebGLRenderer, DoubleSide,
} from "../vendor/three.js";
import { frames, reach } from "../base/kinematics.js";

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const UP = new Vector3(0, 1, 0), AXES = [["#d8475c", [1, 0, 0]], ["#2fa58a", [0, 1, 0]], ["#3d8fd6", [0, 0, 1]]];
const AWAY = 2.55; // of the arm's reach: upright, with its tool, it fills four fifths of the picture's height
const VIEWS = { corner: [1, -1.25, 0.55], front: [1, 0, 0.12], side: [0, -1, 0.12], top: [0.001, 0, 1] };

export class ArmScene {
  /** shape: as /robot/shape tells it; meshes: [{link, place, vertices, triangles}]. */
  constructor(shape, meshes) {
    this.shape = shape;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.canvas = this.renderer.domElement;
    this.scene = new Scene();
    this.size = reach(shape);
    this.camera = new PerspectiveCamera(32, 1, 0.01 * this.size, 20 * this.size);
    this.camera.up.set(...shape.up);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => this.draw());
    this.scene.add(new HemisphereLight(0xffffff, 0x66707c, 2.1));
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(2, -3, 5);
    this.scene.add(sun);
    this.grid = new GridHelper(2 * Math.ceil(this.size), 4 * Math.ceil(this.size));
    this.grid.rotation.x = Math.PI / 2;
    if (Number.isFinite(shape.floor)) { this.grid.position.z = shape.floor; this.scene.add(this.grid); }
    this.surroundings = shape.boxes.map(box);
    for (const { root } of this.surroundings) this.scene.add(root);
    this.arm = this.body(meshes, false);
    this.ghost = this.body(meshes, true);
    this.ghost.root.visible = false;
    this.scene.add(this.arm.root, this.ghost.root);
    this.dress();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.dress(); this.draw(); });
    this.look("corner");
  }

  /** Links, joints and tool as groups that move with their frames. */
  body(meshes, ghost) {
    const root = new Group(), links = [];
    const material = (opacity) => new MeshLambertMaterial({ transparent: ghost, opacity: ghost ? opacity : 1, depthWrite: !ghost, side: DoubleSide });
    const skin = material(0.28), knuckles = this.shape.joints.map(() => material(0.34));
    const linkOf = (k) => (k < 0 ? root : links[k]);
    for (const _ of this.shape.joints) {
      const link = new Group();
      link.matrixAutoUpdate = false;
      links.push(link);
      root.add(link);
    }
    const covered = new Set(meshes.map((mesh) => mesh.link));
    for (const { link, start, end, radius } of this.shape.capsules) {
      if (!covered.has(link)) linkOf(link).add(capsule(new Vector3(...start), new Vector3(...end), 0.8 * radius, skin));
    }
    for (const mesh of meshes) linkOf(mesh.link).add(faces(mesh, skin));
    this.shape.joints.forEach(({ axis, prismatic }, j) => {
      const radius = this.knuckle(j);
      const ring = new Mesh(new CylinderGeometry(radius, radius, prismatic ? 3 * radius : 1.5 * radius, 28), knuckles[j]);
      ring.quaternion.copy(new Quaternion().setFromUnitVectors(UP, new Vector3(...axis)));
      links[j].add(ring);
    });
    const tool = this.shape.capsules.filter((one) => one.link === links.length - 1).at(-1);
    if (!ghost && links.length) {
      const frame = axes(0.12 * this.size);
      if (tool) frame.position.set(...tool.end);
      links.at(-1).add(frame);
      root.add(axes(0.12 * this.size));
    }
    return { root, links, skin, knuckles };
  }

  /** Thick enough to be seen around the body that it moves. */
  knuckle(j) {
    const near = this.shape.capsules.filter((one) => one.link === j || one.link === this.shape.joints[j].parent).map((one) => one.radius);
    return Math.max(0.028 * this.size, 0.92 * Math.max(0, ...near));
  }

  dress() {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.arm.skin.color.set(dark ? "#8e9aa8" : "#b9c3ce");
    this.ghost.skin.color.set(css("--accent"));
    for (const knuckle of this.ghost.knuckles) knuckle.color.set(css("--accent"));
    this.grid.material.color = new Color(dark ? "#4a5561" : "#c3ccd6");
    this.grid.material.vertexColors = false;
    this.grid.material.needsUpdate = true;
    for (const { skin, edge } of this.surroundings) {
      skin.color.set(dark ? "#77664d" : "#d9c9ae");
      edge.color.set(dark ? "#b79f78" : "#8d7b5c");
    }
    this.light(this.lit ?? []);
  }

  /** Joints (from 1) that something is said about. */
  light(joints) {
    this.lit = joints;
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.arm.knuckles.forEach((one, j) => {
      const on = joints.includes(j + 1);
      one.color.set(on ? "#e8842c" : dark ? "#5f7f9e" : "#6d93b8");
      one.emissive.set(on ? "#7a3a00" : "#000000");
    });
  }

  pose(q) { this.place(this.arm, q); }

  ghostPose(q) {
    this.ghost.root.visible = Boolean(q);
    if (q) this.place(this.ghost, q);
  }

  place({ links }, q) {
    frames(this.shape, q).forEach((frame, j) => {
      links[j].matrix.set(...frame);
      links[j].matrixWorldNeedsUpdate = true;
    });
  }

  look(from) {
    const target = new Vector3(...this.shape.up).multiplyScalar(0.42 * this.size);
    const away = new Vector3(...VIEWS[from]).normalize().multiplyScalar(AWAY * this.size);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...this.shape.up));
    this.camera.position.copy(away.applyQuaternion(turn).add(target));
    this.controls.target.copy(target);
    this.controls.update();
    this.draw();
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Once per frame of the screen at most, and only when something has changed. */
  draw() {
    this.due ??= requestAnimationFrame(() => {
      this.due = null;
      this.renderer.render(this.scene, this.camera);
    });
  }
}

function capsule(start, end, radius, material) {
  const way = end.clone().sub(start), length = way.length();
  const made = new Mesh(new CapsuleGeometry(radius, length, 6, 24), material);
  made.position.copy(start).addScaledVector(way, 0.5);
  if (length > 0) made.quaternion.setFromUnitVectors(UP, way.normalize());
  return made;
}

function faces({ place, vertices, triangles }, material) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(vertices, 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  geometry.computeVertexNormals();
  const made = new Mesh(geometry, material);
  made.matrixAutoUpdate = false;
  made.matrix.set(...place);
  return made;
}

/** A solid of the surroundings, which one sees through: the arm may stand behind it. */
function box({ name, size, place }) {
  const corners = [], at = (x, y, z) => 4 * x + 2 * y + z;
  for (const x of [0, 1]) for (const y of [0, 1]) for (const z of [0, 1]) corners.push([x, y, z].map((end, k) => (end - 0.5) * size[k]));
  const sides = [[[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]];
  const flat = [], lines = [];
  for (const side of sides) {
    for (const far of [side, side.map((corner) => corner.map((end, k) => (side.every((one) => one[k] === 0) ? 1 : end)))]) {
      const [a, b, c, d] = far.map((corner) => corners[at(...corner)]);
      flat.push(...a, ...b, ...c, ...a, ...c, ...d); // corners of their own, so that sides stay flat
      lines.push([a, b, c, d, a]);
    }
  }
  const skin = new MeshLambertMaterial({ transparent: true, opacity: 0.55, depthWrite: false, side: DoubleSide });
  const edge = new LineBasicMaterial(), root = new Group();
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(flat), 3));
  geometry.computeVertexNormals();
  root.add(new Mesh(geometry, skin), ...lines.map((points) => new Line(new BufferGeometry().setFromPoints(points.map((one) => new Vector3(...one))), edge)));
  root.matrixAutoUpdate = false;
  root.matrix.set(...place);
  root.name = name;
  return { root, skin, edge };
}

function axes(length) {
  const out = new Group();
  for (const [colour, [x, y, z]] of AXES) {
    const geometry = new BufferGeometry().setFromPoints([new Vector3(), new Vector3(x * length, y * length, z * length)]);
    out.add(new Line(geometry, new LineBasicMaterial({ color: colour })));
  }
  return out;
}
