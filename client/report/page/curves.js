// Curves over the frames, logarithmic, with a cursor. A click calls `pick` with the frame's index.
class Curves {
  static DECADES = 4;  // at most, from the largest value down

  // chart: {title, series: [{name, values}], format}: values are null where there is none, format makes one a text.
  constructor(parent, frames, { title, series, format }, pick) {
    this.frames = frames;
    this.format = format;
    this.series = series.map((s, k) => ({ ...s, color: `var(--curve-${k})` }));
    const all = this.series.flatMap((s) => s.values).filter((v) => v > 0);
    const largest = all.reduce((m, v) => Math.max(m, v), 1e-30);
    const smallest = all.reduce((m, v) => Math.min(m, v), largest);
    this.top = Math.log10(largest) + 0.05;
    this.bottom = Math.max(Math.log10(smallest) - 0.05, this.top - Curves.DECADES);
    if (this.top - this.bottom < 0.5) [this.top, this.bottom] = [this.top + 0.25, this.bottom - 0.25];
    const figure = add(parent, "figure");
    add(figure, "figcaption", title);
    const plot = add(figure, "div", "", "plot");
    this.svg = svg(plot, "svg", { viewBox: "0 0 1000 1000", preserveAspectRatio: "none" });
    this.grid(plot);
    frames.forEach((frame, k) => {
      if (frame.error) svg(this.svg, "path", { d: `M${this.x(k)} 0V1000`, class: "missing" });
    });
    for (const s of this.series) svg(this.svg, "path", { d: this.path(s.values), class: "curve", style: `stroke: ${s.color}` });
    this.cursor = svg(this.svg, "path", { class: "cursor" });
    const key = add(figure, "div", "", "keys");
    for (const s of this.series) {
      const item = add(key, "span");
      add(item, "i").style.background = s.color;
      item.append(s.name + " ");
      s.label = add(item, "b");
    }
    plot.addEventListener("pointerdown", (event) => {
      const box = plot.getBoundingClientRect();
      pick(Math.round(Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * (frames.length - 1)));
    });
  }

  x(k) { return (1000 * k) / Math.max(this.frames.length - 1, 1); }
  y(value) {
    const level = Math.log10(Math.max(value, 1e-300));
    return 1000 * Math.min((this.top - level) / (this.top - this.bottom), 1);
  }

  // Broken where values are missing or zero; one value alone is a dot.
  path(values) {
    return values.map((v, k) => {
      if (!(v > 0)) return "";
      return `${k > 0 && values[k - 1] > 0 ? "L" : "M"}${this.x(k).toFixed(1)} ${this.y(v).toFixed(1)}h0`;
    }).join("");
  }

  grid(plot) {
    const decades = this.top - this.bottom, digits = decades > 2.4 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 5];
    for (let decade = Math.floor(this.bottom); decade <= this.top; ++decade) {
      for (const digit of digits) {
        const value = digit * 10 ** decade, y = this.y(value);
        if (value > 10 ** this.top || value < 10 ** this.bottom) continue;
        svg(this.svg, "path", { d: `M0 ${y}H1000`, class: "grid" });
        add(plot, "span", this.format(value), "tick").style.top = `${y / 10}%`;
      }
    }
    const last = this.frames.length - 1;
    for (const k of new Set([0, Math.round(last / 2), last])) {
      const tick = add(plot, "span", String(this.frames[k].frame), "x-tick");
      tick.style.left = `${this.x(k) / 10}%`;
    }
  }

  show(k) {
    this.cursor.setAttribute("d", `M${this.x(k)} 0V1000`);
    for (const s of this.series) s.label.textContent = s.values[k] === null ? "–" : this.format(s.values[k]);
  }
}
