// A flat canvas that is sharp on any screen.
const FINEST = 2; // picture elements a pixel: more cannot be seen, and costs

/** Give a canvas the size of a box [pixels] and return its blank drawing, in pixels. */
export function fitted(canvas, { width, height }) {
  const ratio = Math.min(FINEST, window.devicePixelRatio || 1);
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const g = canvas.getContext("2d");
  g.scale(ratio, ratio);
  g.font = "12px system-ui, sans-serif";
  return g;
}
