"use strict";
// What the page was given (client/report/payload.h).

function readArray(bytes, begin, { width, count, stride }) {
  const values = new { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array }[width](count);
  for (let plane = 0; plane < width; ++plane) {
    const at = begin + plane * count;
    for (let i = 0; i < count; ++i) values[i] |= bytes[at + i] << (8 * plane);
  }
  if (stride > 0) for (let i = stride; i < count; ++i) values[i] += values[i - stride];
  return values;
}

// Resolves to the header, its "arrays" by name.
async function readPayload(text) {
  if (!("DecompressionStream" in window)) throw new Error("This browser is too old for the report: it needs one of 2023 or later");
  const deflated = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const end = 4 + new DataView(bytes.buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, end)));
  const arrays = {};
  let at = end;
  for (const array of header.arrays) {
    arrays[array.name] = readArray(bytes, at, array);
    at += array.width * array.count;
  }
  return { ...header, arrays };
}
