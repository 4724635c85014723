// The 3D view: the limit surface, the control mesh and the target of one frame.
class View3d {
  constructor(canvas, sequence, up) {
    this.sequence = sequence;
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 1, 10);
    const light = new THREE.DirectionalLight(0xffffff, 0.68);
    light.position.set(0.4, 0.7, 1);
    this.camera.add(light, light.target);
    light.target.position.set(0, 0, -1);
    this.scene.add(new THREE.AmbientLight(0xffffff, 0.48), this.camera);

    const { arrays } = sequence;
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setIndex(new THREE.BufferAttribute(arrays.triangles, 1));
    const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.surface = new THREE.Mesh(this.geometry,
      new THREE.MeshLambertMaterial({ vertexColors: THREE.VertexColors, side: THREE.DoubleSide, ...offset }));
    this.wireframe = new THREE.Mesh(this.geometry,
      new THREE.MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.25 }));
    this.points = new THREE.Points(new THREE.BufferGeometry(),
      new THREE.PointsMaterial({ vertexColors: THREE.VertexColors, size: 2.5, sizeAttenuation: false }));
    this.cage = View3d.lines(1.2, 0.6);
    this.cageCreases = View3d.lines(3);
    this.creases = View3d.lines(3);
    this.borders = View3d.lines(2.5);
    this.scene.add(this.surface, this.wireframe, this.points, this.cage, this.cageCreases, this.creases, this.borders);
    for (const thing of this.scene.children) thing.frustumCulled = false;
    this.samples = View3d.someVertices(sequence);
    this.box = new THREE.Box3().setFromPoints(this.samples);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.setUp(up);
  }

  static lines(width, opacity = 1) {
    const material = new THREE.LineMaterial({ linewidth: width, transparent: true, opacity });
    return new THREE.LineSegments2(new THREE.LineSegmentsGeometry(), material);
  }

  static setLines(lines, edges, positions) {
    const ends = new Float32Array(3 * edges.length);
    edges.forEach((v, k) => { for (let c = 0; c < 3; ++c) ends[3 * k + c] = positions[3 * v + c]; });
    const attribute = lines.geometry.attributes.instanceStart;
    if (attribute === undefined) return lines.geometry.setPositions(ends);
    attribute.data.array.set(ends);
    attribute.data.needsUpdate = true;
  }

  setUp(up) {
    this.camera.up.set(0, up === "Y" ? 1 : 0, up === "Y" ? 0 : 1);
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.enableKeys = false;  // arrows are for frames
    this.controls.addEventListener("change", () => this.draw());
    this.resetView();
  }

  // Of the surface in all frames: where things move.
  static someVertices(sequence) {
    const samples = [], step = 3 * Math.ceil(sequence.rows / 500);
    sequence.frames.forEach((_, k) => {
      const limit = sequence.limit(sequence.control(k));
      for (let at = 0; at < limit.length; at += step) samples.push(new THREE.Vector3().fromArray(limit, at));
    });
    return samples;
  }

  // From the front, slightly from the right and from above, as near as all frames allow.
  resetView() {
    const { camera, controls } = this, shift = this.points.position;
    this.box.getCenter(controls.target).addScaledVector(shift, 0.5);
    camera.position.copy(controls.target).add(camera.up.y ? new THREE.Vector3(0.45, 0.35, 1) : new THREE.Vector3(0.45, -1, 0.35));
    camera.lookAt(controls.target);
    const toCamera = camera.quaternion.clone().inverse(), slope = Math.tan((camera.fov * Math.PI) / 360);
    let distance = 1e-30;
    for (const sample of this.samples) {
      for (const offset of [0, 1]) {
        const { x, y, z } = sample.clone().addScaledVector(shift, offset).sub(controls.target).applyQuaternion(toCamera);
        distance = Math.max(distance, z + Math.max(Math.abs(x) / camera.aspect, Math.abs(y)) / slope);
      }
    }
    camera.position.sub(controls.target).setLength(1.1 * distance).add(controls.target);
    camera.near = distance / 100;
    camera.far = distance * 100;
    camera.updateProjectionMatrix();
    controls.update();
    this.draw();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.renderer.setSize(clientWidth, clientHeight, false);
    const isFirst = this.size === undefined;
    this.size = [clientWidth, clientHeight];
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    for (const lines of [this.cage, this.cageCreases, this.creases, this.borders]) {
      lines.material.resolution.set(clientWidth, clientHeight);
    }
    isFirst ? this.resetView() : this.draw();
  }

  // Frame k of the sequence.
  show(k) {
    const { arrays, cageEdges } = this.sequence;
    const control = this.sequence.control(k), limit = this.sequence.limit(control);
    this.frame = k;
    this.geometry.setAttribute("position", new THREE.BufferAttribute(this.sequence.drawn(limit), 3));
    this.geometry.computeVertexNormals();
    this.points.geometry.setAttribute("position", new THREE.BufferAttribute(this.sequence.points(k), 3));
    View3d.setLines(this.cage, cageEdges, control);
    if (arrays.cage_creases.length) View3d.setLines(this.cageCreases, arrays.cage_creases, control);
    if (arrays.creases.length) View3d.setLines(this.creases, arrays.creases, limit);
    if (arrays.borders.length) View3d.setLines(this.borders, arrays.borders, limit);
    this.paint();
  }

  // {surface, wireframe, cage, features: drawn or not, target: none, over or beside, mode: of colours, scale: units}
  setOptions(options) {
    const shift = options.target === "beside" ? 1.15 * (this.box.max.x - this.box.min.x) : 0;
    this.options = options;
    this.surface.visible = options.surface;
    this.wireframe.visible = options.wireframe;
    this.cage.visible = options.cage;
    this.cageCreases.visible = options.cage && options.features && this.sequence.hasCreases;
    this.creases.visible = options.features && this.sequence.hasCreases;
    this.borders.visible = options.features && this.sequence.arrays.borders.length > 0;
    this.points.visible = options.target !== "none";
    if (shift !== this.points.position.x) {
      this.points.position.x = shift;
      this.resetView();
    }
    if (this.frame !== undefined) this.paint();
  }

  paint() {
    const colors = codeColors(this.options.mode, this.sequence, this.options.scale);
    const set = (geometry, codes) => {
      const values = new Float32Array(3 * codes.length);
      codes.forEach((code, k) => values.set(colors[code], 3 * k));
      geometry.setAttribute("color", new THREE.BufferAttribute(values, 3));
    };
    set(this.geometry, this.sequence.surfaceCodes(this.frame));
    set(this.points.geometry, this.sequence.pointCodes(this.frame));
    this.draw();
  }

  // Takes the page's colours, which change with the scheme.
  readTheme() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => new THREE.Color(style.getPropertyValue(name).trim());
    this.renderer.setClearColor(color("--stage"));
    this.cage.material.color = color("--cage");
    this.wireframe.material.color = color("--text");
    this.creases.material.color = this.cageCreases.material.color = color("--crease");
    this.borders.material.color = color("--border-line");
    this.draw();
  }

  draw() {
    if (this.size !== undefined && this.frame !== undefined) this.renderer.render(this.scene, this.camera);
  }
}
