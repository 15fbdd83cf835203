// Geometry of planar arms in the page's frame: x to the right, y upwards, m; link 1 upwards at mid-stroke.

/** Returns the arm's lengths, the angle of its elbow, and the direction of link 1 at mid-stroke. */
export function armGeometry(entry, parameters) {
  const { arm } = parameters;
  const [gravity, direction] = entry.gravity;
  const base = gravity > 0 ? -Math.PI / 2 - direction : Math.PI / 2;
  if (parameters.joints.length === 1) return { lengths: [arm.length], turns: [base], isUpright: gravity > 0 };
  return { lengths: [arm.length_1, arm.length_2], turns: [base, arm.elbow], isUpright: gravity > 0 };
}

/** Returns directions of the links at joint angles (rad), and the places of joints and tip. */
export function pose(geometry, angles) {
  const points = [[0, 0]];
  const directions = [];
  let direction = 0;
  angles.forEach((angle, j) => {
    direction += geometry.turns[j] + angle;
    const [x, y] = points[j];
    points.push([x + geometry.lengths[j] * Math.cos(direction), y + geometry.lengths[j] * Math.sin(direction)]);
    directions.push(direction);
  });
  return { points, directions };
}

/** Returns the box around all places that the arm reaches within +-strokes: [left, bottom, right, top], m. */
export function reachedBox(geometry, strokes) {
  const box = [-0.1, -0.12, 0.1, 0.1];
  const samples = 12;
  const angle = (stroke, i) => stroke * ((2 * i) / samples - 1);
  for (let i = 0; i <= samples; i++) {
    for (let k = 0; k <= (strokes.length > 1 ? samples : 0); k++) {
      for (const [x, y] of pose(geometry, strokes.map((stroke, j) => angle(stroke, j ? k : i))).points) {
        box[0] = Math.min(box[0], x);
        box[1] = Math.min(box[1], y);
        box[2] = Math.max(box[2], x);
        box[3] = Math.max(box[3], y);
      }
    }
  }
  return box;
}

/** Returns the joint angles at which the tip is nearest to a place, each within +-strokes; on the side of `angles`. */
export function anglesAt(geometry, strokes, [x, y], angles) {
  if (angles.length === 1) return [clamp(wrapped(Math.atan2(y, x) - geometry.turns[0]), strokes[0])];
  const [a, b] = geometry.lengths;
  const cosine = Math.min(Math.max((x * x + y * y - a * a - b * b) / (2 * a * b), -1), 1);
  const side = Math.sin(geometry.turns[1] + angles[1]) < 0 ? -1 : 1;
  const bend = side * Math.acos(cosine);
  const second = clamp(wrapped(bend - geometry.turns[1]), strokes[1]);
  const bent = second + geometry.turns[1];
  const direction = Math.atan2(y, x) - Math.atan2(b * Math.sin(bent), a + b * Math.cos(bent));
  return [clamp(wrapped(direction - geometry.turns[0]), strokes[0]), second];
}

/** Returns the torques on the joints of a force (N) at a place on link `link`: the transposed Jacobian times it. */
export function torquesOf({ points }, link, [x, y], [forceX, forceY]) {
  return points.slice(0, -1).map(([px, py], j) => (j > link ? 0 : (x - px) * forceY - (y - py) * forceX));
}

/** Returns the link nearest to a place, the nearest place on it as a fraction of its length, and the distance. */
export function nearestLink({ points }, [x, y]) {
  let best = { link: 0, fraction: 1, distance: Infinity };
  for (let j = 0; j + 1 < points.length; j++) {
    const [ax, ay] = points[j];
    const [dx, dy] = [points[j + 1][0] - ax, points[j + 1][1] - ay];
    const fraction = Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0), 1);
    const distance = Math.hypot(x - ax - fraction * dx, y - ay - fraction * dy);
    if (distance < best.distance) best = { link: j, fraction, distance };
  }
  return best;
}

function wrapped(angle) {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

function clamp(value, limit) {
  return Math.min(Math.max(value, -limit), limit);
}
