// Lines, circles, words and markers, in the colours and shapes of the styles.

export const HALO = 'rgba(255,255,255,0.9)'
const DASH = { '-': [], '--': [7, 4], ':': [1.5, 3.5], '-.': [8, 3, 2, 3] }

// Draws points of the world as a camera sees them.
export class Pen {
  constructor(context, camera) {
    Object.assign(this, { context, camera, font: 13, scale: 1 })
  }

  style({ color, linestyle }, width) {
    Object.assign(this.context, { strokeStyle: color, fillStyle: color, lineWidth: width })
    this.context.setLineDash(DASH[linestyle] ?? [])
    this.pen = [NaN, NaN] // where the last line ended
  }

  segment(p, q) {
    const ends = this.camera.segment(p, q)
    if (ends) this.straight(...ends)
  }

  straight(from, to) {
    if (Math.max(...[...from, ...to].map(Math.abs)) > 1e6) return
    if (from.some((v, i) => v !== this.pen[i])) this.context.moveTo(...from)
    this.context.lineTo(...to)
    this.pen = to
  }

  circle([x, y], radius, style, width = 1.6) {
    this.style({ color: style.color }, width)
    this.context.beginPath()
    this.context.arc(x, y, radius, 0, 2 * Math.PI)
    this.context.stroke()
  }

  marker(style, at, scale = 1) {
    drawMarker(this.context, style, at, scale * this.scale)
  }

  text(words, [x, y], color, align, weight = '') {
    const { context } = this
    Object.assign(context, { font: `${weight}${this.font * Math.min(Math.max(this.scale, 0.85), 1)}px sans-serif`, textAlign: align, textBaseline: 'middle' })
    context.setLineDash([])
    Object.assign(context, { strokeStyle: HALO, lineWidth: 3, fillStyle: color })
    context.strokeText(words, x, y)
    context.fillText(words, x, y)
  }
}

// The markers of matplotlib that the styles use.
export function drawMarker(context, { color, marker, fillstyle }, [x, y], scale = 1) {
  const r = { '*': 7, o: 3.6, '+': 6, x: 5, s: 5, D: 4.8, v: 5, 0: 6 }[marker] * scale
  const corners = {
    '*': Array.from({ length: 10 }, (_, i) => [(i * Math.PI) / 5, i % 2 ? 0.4 : 1]),
    s: [1, 3, 5, 7].map(i => [(i * Math.PI) / 4, 1.3]),
    D: [0, 1, 2, 3].map(i => [(i * Math.PI) / 2, 1.2]),
    v: [1, 3, 5].map(i => [(i * Math.PI) / 3, 1.1]),
  }[marker]
  Object.assign(context, { strokeStyle: color, fillStyle: color, lineWidth: 1.7 })
  context.setLineDash([])
  context.beginPath()
  if (corners) {
    corners.forEach(([a, s], i) => context[i ? 'lineTo' : 'moveTo'](x + r * s * Math.sin(a), y - r * s * Math.cos(a)))
    context.closePath()
  } else if (marker === 'o' || marker === '0') {
    context.arc(x, y, r, 0, 2 * Math.PI)
  }
  const strokes = { '+': [[-1, 0, 1, 0], [0, -1, 0, 1]], x: [[-1, -1, 1, 1], [-1, 1, 1, -1]], 0: [[-0.7, 0.7, 0.7, -0.7]] }
  for (const [a, b, c, e] of strokes[marker] ?? []) {
    context.moveTo(x + r * a, y + r * b)
    context.lineTo(x + r * c, y + r * e)
  }
  if (fillstyle === 'none') Object.assign(context, { fillStyle: 'rgba(255,255,255,0.75)' })
  if (corners || marker === 'o') context.fill()
  context.stroke()
}
