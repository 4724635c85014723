// The switches beside the 3D view, and the scale of its colours.
class Panel {
  constructor(view, data) {
    this.data = data;
    const { arrays } = data;
    for (const [id, edges] of [["has-creases", arrays.creases], ["has-borders", arrays.borders]]) $(id).hidden = edges.length === 0;
    $("show-features").parentElement.hidden = arrays.creases.length + arrays.borders.length === 0;
    $("up").value = data.up_axis;
    const apply = () => view.setOptions(this.options());
    $("panel").addEventListener("input", apply);
    $("scale").addEventListener("dblclick", () => { $("scale").value = 0; apply(); });
    $("up").addEventListener("input", () => view.setUp($("up").value));
    $("reset").addEventListener("click", () => view.resetView());
    apply();
  }

  options() {
    const mode = $("mode").value, is = (id) => $(id).checked;
    const scale = (this.data.scene.robust_deviation || 1e-30) * 2 ** Number($("scale").value);
    this.showLegend(mode, scale);
    return { surface: is("show-surface"), wireframe: is("show-wireframe"), cage: is("show-cage"), features: is("show-features"),
      target: $("target").value, mode, scale };
  }

  showLegend(mode, scale) {
    const { diagonal } = this.data.report.total;
    $("legend").hidden = mode === "plain";
    $("bar").style.background = mapGradient(mode);
    $("ticks").replaceChildren();
    for (const share of mode === "signed" ? [-1, 0, 1] : [0, 0.5, 1]) {
      const tick = add($("ticks"), "span", diagonal > 0 ? percent((100 * share * scale) / diagonal) : "");
      add(tick, "small", short(share * scale));
    }
    $("scale-note").textContent = mode === "signed" ? "Blue: the surface lies inside of the target. Red: outside."
      : "Percent of the diagonal; below, units.";
  }
}
