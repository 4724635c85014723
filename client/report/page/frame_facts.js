// What report.json says of a frame.

// Percent of the diagonal: exact where it was measured, null where there is none.
function frameDistances(frame, diagonal) {
  const d = frame.distances || frame.sampled_distances;
  const of = (name) => {
    if (!d) return null;
    return d[`${name}_percent`] ?? (diagonal > 0 ? (100 * d[name]) / diagonal : null);
  };
  return { mean: of("mean"), rms: of("rms"), max: of("max"), isSampled: Boolean(d) && !frame.distances };
}

function frameState(frame) {
  if (!frame.error) return { VERDICT_SUSPECT: "suspect", VERDICT_LOST: "lost" }[frame.verdict] || "ok";
  if (/^skipped/.test(frame.error.message)) return "skipped";
  return frame.error.code === "UNAVAILABLE" ? "not answered" : "refused";
}

// Of work, without waiting for its turn.
function frameMilliseconds(frame) {
  return Object.entries(frame.milliseconds || {}).reduce((sum, [stage, ms]) => sum + (stage === "queue" ? 0 : ms), 0);
}

// Columns of the table. `distances`: of each frame.
function frameColumns(frames, distances, diagonal) {
  const value = (name, of, text) => ({ name, text, of: (frame, k) => {
    const found = frame.error ? null : of(frame, k);
    return found === null || found === undefined ? null : Number(found);
  } });
  const share = (v) => v.toFixed(4), hasDrift = frames.some((frame) => frame.drift);
  return [
    { name: "Frame", of: (frame) => frame.frame, text: String },
    { name: "State", of: frameState },
    value("mean, %", (_, k) => distances[k].mean, share),
    value("RMS, %", (_, k) => distances[k].rms, share),
    value("max, %", (_, k) => distances[k].max, share),
    ...(hasDrift ? [value("drift RMS, %", (frame) => frame.drift?.rms_percent, share)] : []),
    value("noise, %", (frame) => (100 * frame.noise) / diagonal, share),
    value("points", (frame) => frame.points, String),
    value("outliers", (frame) => frame.outliers, String),
    value("steps", (frame) => frame.iterations, String),
    value("ms", frameMilliseconds, (v) => v.toFixed(1)),
    value("bytes", (frame) => frame.delta_bytes, String),
    { name: "File", of: (frame) => frame.file || "" },
    { name: "Message", of: (frame) => (frame.error ? frame.error.message : "") },
  ];
}

// Classes of the frames' rows: their state, and the three with the largest RMS.
function frameMarks(frames, distances) {
  const rms = distances.map((d) => d.rms).filter((v) => v !== null).sort((a, b) => b - a);
  const worst = rms.length > 5 ? rms[2] : Infinity;
  const isWorst = ({ rms }) => rms !== null && rms >= worst;
  return frames.map((frame, k) => frameState(frame).replace(" ", "-") + (isWorst(distances[k]) ? " worst" : ""));
}

// Charts: [{title, series: [{name, values}], format}], those that have anything to show.
function frameCharts(frames, distances) {
  const values = (name, of) => frames.map((frame, k) => (frame.error ? null : of(frame, k, name) ?? null));
  const series = (names, of) => names.map((name) => ({ name, values: values(name, of) }))
    .filter((s) => s.values.some((v) => v > 0));
  const energies = ["distance", "coverage", "arap", "boundary", "image", "landmarks"];
  const stages = ["solve", "index", "decode", "measure", "encode", "template"];
  const sampled = distances.some((d) => d.isSampled) ? " (sampled)" : "";
  return [
    { title: `Distance, % of the diagonal${sampled}`, format: percent,
      series: series(["RMS", "max", "mean"], (_, k, name) => distances[k][name.toLowerCase()]) },
    { title: "Drift, % of the diagonal", format: percent,
      series: series(["RMS", "max", "mean"], (frame, _, name) => frame.drift?.[`${name.toLowerCase()}_percent`]) },
    { title: "Energies at the end", format: short, series: series(energies, (frame, _, name) => frame.final_energies?.[name]) },
    { title: "Time, ms", format: short, series: series(stages, (frame, _, name) => frame.milliseconds?.[name]) },
  ].filter((chart) => chart.series.length > 0);
}
