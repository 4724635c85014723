// Puts the page together and keeps its parts at one frame.
function showError(error) {
  $("error").hidden = false;
  $("error").textContent = `Something went wrong: ${error?.message ?? error}`;
}
window.addEventListener("error", (event) => showError(event.error ?? event.message));
window.addEventListener("unhandledrejection", (event) => showError(event.reason));

class Page {
  constructor(data) {
    this.data = data;
    const { report } = data, { frames, total } = report;
    this.frames = frames;
    this.distances = frames.map((frame) => frameDistances(frame, total.diagonal));
    this.fillHead(report);
    this.fillSettings(report);
    const pick = (k) => this.player.jump(k), marks = frameMarks(frames, this.distances);
    this.parts = [new Table($("table"), frames, frameColumns(frames, this.distances, total.diagonal), marks, pick)];
    const charts = frames.length > 1 ? frameCharts(frames, this.distances) : [];
    for (const chart of charts) this.parts.push(new Curves($("curves"), frames, chart, pick));
    this.setUpView();
    if (frames.length === 0) return;
    this.player = new Player(frames.map((frame) => frame.frame), data.frames_per_second, (k) => this.show(k));
    this.player.jumpToFragment();
  }

  fillHead({ session, total, cagefit }) {
    const name = session?.name || "Cagefit report";
    document.title = `${name} \u2013 Cagefit report`;
    $("name").textContent = name;
    const subtitle = [`diagonal ${digits(total.diagonal, 4)}`];
    if (session?.control_vertices) subtitle.unshift(`${session.control_vertices} control vertices`);
    if (session?.created) subtitle.push(`${session.created.slice(0, 16).replace("T", " ")} UTC`);
    if (cagefit) subtitle.push(`Cagefit ${cagefit}`);
    $("subtitle").textContent = subtitle.join(" \u00B7 ");
    const tiles = [["frames fitted", `${total.fitted} of ${total.frames}`]];
    for (const key of ["refused", "skipped", "unanswered", "suspect", "lost"]) {
      if (total[key] > 0) tiles.push([key, total[key], "bad"]);
    }
    tiles.push(["RMS, mean", percent(total.mean_rms_percent)], ["RMS, worst", percent(total.worst_rms_percent)]);
    if (total.drift) tiles.push(["drift, RMS", percent(total.drift.rms_percent)]);
    tiles.push(["seconds in all", digits(total.seconds)]);
    if (total.frames_per_second > 0) tiles.push(["frames a second", digits(total.frames_per_second)]);
    for (const [label, value, mark] of tiles) {
      const tile = add($("totals"), "div", "", mark);
      add(tile, "dt", label);
      add(tile, "dd", value);
    }
  }

  fillSettings({ settings, session }) {
    const { options, ...others } = session ?? {};
    for (const [path, value] of flatten({ ...(settings ?? { options }), session: others })) {
      const row = add($("setting-list"), "div");
      add(row, "span", path);
      add(row, "b", value === null || String(value) === "" ? "\u2013" : Array.isArray(value) ? value.join(", ") : String(value));
    }
  }

  setUpView() {
    const { scene, arrays, up_axis } = this.data;
    const hasScene = Boolean(scene) && scene.frames.length > 0;
    document.body.classList.toggle("no-scene", !hasScene);
    if (!hasScene) return;
    try {
      this.view = new View3d($("canvas"), new Sequence(scene, arrays), up_axis);
    } catch (error) {
      return showError(`this browser draws nothing in 3D (${error.message})`);
    }
    new Panel(this.view, this.data);
    this.view.readTheme();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.view.readTheme());
  }

  show(k) {
    const frame = this.frames[k];
    for (const part of this.parts) part.show(k);
    $("frame-title").textContent = `Frame ${frame.frame}: ${frameState(frame)}`;
    $("frame").replaceChildren();
    const { rms, max } = this.distances[k], solve = frame.milliseconds?.solve ?? 0;
    const facts = frame.error ? [["", frame.error.message]] : [["RMS", percent(rms)], ["max", percent(max)],
      ["steps", frame.iterations], ["points", frame.points], ["solve", `${digits(solve)} ms`]];
    for (const [label, value] of facts) {
      add($("frame"), "dt", label);
      add($("frame"), "dd", value);
    }
    if (this.view) this.showScene(frame);
  }

  // That frame where it is drawn; otherwise the last one before it that is.
  showScene(frame) {
    const drawn = this.data.scene.frames;
    const k = Math.max(drawn.findLastIndex((other) => other.frame <= frame.frame), 0);
    if (k !== this.view.frame) this.view.show(k);
    const { frame: number, points, target_points: all } = drawn[k];
    $("notice").hidden = number === frame.frame;
    const reason = frame.error ? `Frame ${frame.frame} has no fit (${frameState(frame)}).`
      : `Of this sequence, ${drawn.length} frames are drawn; the table and the curves have all.`;
    $("notice").textContent = `${reason} Drawn: frame ${number}.`;
    $("caption").textContent = all > 0 ? `Target: ${points} of ${all} points` : "The target could not be read again.";
  }
}

readPayload($("data").textContent).then((data) => new Page(data)).then(() => document.body.classList.add("ready"), showError);
