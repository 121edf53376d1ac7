// Where the links of an arm are: frames of a chain as /robot/shape tells it, 4 × 4, row by row.

/** One frame per joint, in the base frame, for positions q (rad; m where a joint slides). */
export function frames({ joints, order }, q) {
  const out = [];
  for (const j of order) {
    const { parent, rotation, translation, axis, prismatic } = joints[j];
    const [x, y, z] = translation, r = rotation;
    const fixed = [r[0], r[1], r[2], x, r[3], r[4], r[5], y, r[6], r[7], r[8], z, 0, 0, 0, 1];
    const here = parent < 0 ? fixed : times(out[parent], fixed);
    out[j] = times(here, prismatic ? along(axis, q[j]) : about(axis, q[j]));
  }
  return out;
}

const along = ([x, y, z], d) => [1, 0, 0, d * x, 0, 1, 0, d * y, 0, 0, 1, d * z, 0, 0, 0, 1];

/** Rodrigues' rotation about a unit vector. */
function about([x, y, z], angle) {
  const c = Math.cos(angle), s = Math.sin(angle), v = 1 - c;
  return [c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0,
          y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0,
          z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0, 0, 0, 0, 1];
}

export function times(a, b) {
  const out = new Array(16);
  for (let i = 0; i < 4; i += 1) {
    for (let k = 0; k < 4; k += 1) {
      out[4 * i + k] = a[4 * i] * b[k] + a[4 * i + 1] * b[4 + k] + a[4 * i + 2] * b[8 + k] + a[4 * i + 3] * b[12 + k];
    }
  }
  return out;
}

/** How far the arm reaches at most, m. */
export const reach = ({ joints, capsules }) =>
  joints.reduce((sum, { translation }) => sum + Math.hypot(...translation), 0)
  + Math.max(0.1, ...capsules.filter((one) => one.link === joints.length - 1).map((one) => Math.hypot(...one.end)));
