// A fitted sequence (client/report/scene_payload.h): vertices of its frames, from control vertices and stencils.
class Sequence {
  constructor(scene, arrays) {
    this.scene = scene;
    this.arrays = arrays;
    this.frames = scene.frames;
    this.rows = arrays.row_sizes.length;
    this.hasCreases = arrays.creases.length > 0;
    this.pointBegins = [0];
    for (const frame of this.frames) this.pointBegins.push(this.pointBegins.at(-1) + frame.points);
    this.cageEdges = Sequence.edges(arrays.cage_triangles);
  }

  // Each once, as pairs of vertices.
  static edges(triangles) {
    const seen = new Set(), edges = [];
    for (let k = 0; k < triangles.length; ++k) {
      const a = triangles[k], b = triangles[k % 3 === 2 ? k - 2 : k + 1];
      const key = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
      if (!seen.has(key)) edges.push(a, b);
      seen.add(key);
    }
    return edges;
  }

  static positions(codes, begin, end, { origin, quantum }) {
    const positions = new Float32Array(end - begin);
    for (let i = 0; i < positions.length; ++i) positions[i] = origin[i % 3] + quantum * codes[begin + i];
    return positions;
  }

  control(k) {
    const size = 3 * this.scene.control_vertices;
    return Sequence.positions(this.arrays.control, k * size, (k + 1) * size, this.scene.control);
  }

  points(k) {
    return Sequence.positions(this.arrays.points, 3 * this.pointBegins[k], 3 * this.pointBegins[k + 1], this.scene.points);
  }

  // Limit vertices.
  limit(control) {
    const { row_sizes, columns, weights } = this.arrays;
    const positions = new Float32Array(3 * this.rows);
    for (let row = 0, entry = 0; row < this.rows; ++row) {
      let x = 0, y = 0, z = 0;
      for (const end = entry + row_sizes[row]; entry < end; ++entry) {
        const at = 3 * columns[entry], weight = weights[entry] / 65535;
        x += weight * control[at];
        y += weight * control[at + 1];
        z += weight * control[at + 2];
      }
      positions.set([x, y, z], 3 * row);
    }
    return positions;
  }

  // Drawn vertices.
  drawn(limit) {
    const positions = new Float32Array(3 * this.arrays.limit_vertices.length);
    this.arrays.limit_vertices.forEach((v, k) => { for (let c = 0; c < 3; ++c) positions[3 * k + c] = limit[3 * v + c]; });
    return positions;
  }

  // Codes of the drawn vertices' deviations, and of the points'.
  surfaceCodes(k) {
    const codes = this.arrays.deviations.subarray(k * this.rows, (k + 1) * this.rows);
    return Uint8Array.from(this.arrays.limit_vertices, (v) => codes[v]);
  }

  pointCodes(k) {
    return this.arrays.point_deviations.subarray(this.pointBegins[k], this.pointBegins[k + 1]);
  }

  // Units.
  deviation(code) {
    const share = (code - 128) / 127;
    return Math.sign(share) * share * share * this.scene.most_deviation;
  }
}
