// Which of `count` frames is shown: by slider, keys, time and #frame=NUMBER. Calls show(k).
class Player {
  constructor(numbers, framesPerSecond, show) {
    this.numbers = numbers;
    this.show = show;
    $("player").hidden = numbers.length < 2;
    $("slider").max = numbers.length - 1;
    $("speed").value = framesPerSecond;
    $("slider").addEventListener("input", () => this.jump(Number($("slider").value)));
    $("play").addEventListener("click", () => this.play(!this.isPlaying));
    window.addEventListener("hashchange", () => this.jumpToFragment());
    window.addEventListener("keydown", (event) => this.press(event));
  }

  jumpToFragment() {
    const match = /^#frame=(\d+)$/.exec(location.hash);
    this.jump(match ? Math.max(this.numbers.indexOf(Number(match[1])), 0) : 0);
  }

  press(event) {
    const { tagName, type } = event.target, last = this.numbers.length - 1;
    if (tagName === "SELECT" || tagName === "BUTTON" || type === "number" || event.target.id === "scale") return;
    const to = { ArrowLeft: this.current - 1, ArrowRight: this.current + 1, Home: 0, End: last }[event.key];
    if (to === undefined && event.key !== " ") return;
    event.preventDefault();
    if (event.key === " ") this.play(!this.isPlaying);
    else this.jump(Math.min(Math.max(to, 0), last));
  }

  jump(k) {
    this.play(false);
    this.set(k);
  }

  set(k) {
    this.current = k;
    $("slider").value = k;
    $("position").textContent = `${this.numbers[k]} / ${this.numbers.at(-1)}`;
    this.show(k);
  }

  play(on) {
    this.isPlaying = on && this.numbers.length > 1;
    $("play").textContent = this.isPlaying ? "\u275A\u275A" : "\u25B6";
    $("play").ariaLabel = this.isPlaying ? "Pause" : "Play";
    if (!this.isPlaying) return;
    const first = this.current;
    let begin = null;
    const step = (now) => {
      if (!this.isPlaying) return;
      begin ??= now;
      const k = (first + Math.floor(((now - begin) / 1000) * (Number($("speed").value) || 24))) % this.numbers.length;
      if (k !== this.current) this.set(k);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}
