/**
 * The canvas's way to draw. Where there is no graphics processor, it is one without antialiasing,
 * which takes three times as long there.
 */
export function contextOf(canvas: HTMLCanvasElement): WebGL2RenderingContext | undefined {
  const wanted: WebGLContextAttributes = { alpha: true, depth: true, stencil: false, powerPreference: 'high-performance' };
  const context = canvas.getContext('webgl2', { ...wanted, antialias: true, failIfMajorPerformanceCaveat: true })
    ?? canvas.getContext('webgl2', { ...wanted, antialias: false });
  return context ?? undefined;
}
