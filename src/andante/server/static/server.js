// What the server is asked. Every answer is its whole state, or an error in words.

async function ask(path, body) {
  let answer;
  try {
    answer = await fetch(path, body === undefined ? {} : {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(body),
    });
  } catch {
    throw new Error("The server does not answer. Is andante teach still running in its terminal?");
  }
  const values = await answer.json().catch(() => ({ error: `The server answered ${answer.status} without words.` }));
  if (!answer.ok) throw new Error(values.error);
  return values;
}

export const state = () => ask("/state");
// `which` tells one anchor from another of its kind: {frame, azimuth_deg}, or {}.
export const search = (anchor, which) => ask("/search", { anchor, ...which });
export const stopSearch = () => ask("/search/stop", {});
export const draw = (name, relation) => ask("/landmarks", { name, ...relation });
export const remove = (name) => ask("/landmarks/remove", { name });
export const save = (leftOut) => ask("/save", { left_out: leftOut });

export function pictureUrl(index, window, heightPx) {
  const query = new URLSearchParams({ azimuth: window.azimuth.toFixed(5), width: window.width.toFixed(5) });
  if (heightPx) query.set("height_px", heightPx);
  return `/frames/${index}.jpg?${query}`;
}
