// From metres to pixels in the plane: a plan that can be moved and zoomed.
import { outer } from './log.js'

export class Plan {
  constructor() {
    this.target = [0, 0] // what is in the middle
    this.size = [100, 100] // of the picture, pixels
    this.scale = 50 // pixels for a metre
    this.touched = false // by the user: then it stays where it is
  }

  // A point in pixels; null for none.
  project(p) {
    const [x, y] = p ?? [NaN, NaN], [w, h] = this.size
    const at = [w / 2 + this.scale * (x - this.target[0]), h / 2 - this.scale * (y - this.target[1])]
    return at.every(Number.isFinite) ? at : null
  }

  segment(p, q) {
    return [this.project(p), this.project(q)]
  }

  // The k-sigma ellipse, with L L' the covariance: half-axes in pixels, angle as the canvas has it.
  outline(p, L, k) {
    const [x, y] = this.project(p), [[a, b], [, c]] = outer(L)
    const mean = (a + c) / 2, half = Math.hypot((a - c) / 2, b)
    const [major, minor] = [mean + half, mean - half].map(v => k * this.scale * Math.sqrt(Math.max(v, 0)))
    return { x, y, major, minor, angle: -Math.atan2(2 * b, a - c) / 2 }
  }

  move(dx, dy) {
    this.target = [this.target[0] - dx / this.scale, this.target[1] + dy / this.scale]
    this.touched = true
  }

  // Come closer; the point under [x, y] stays where it is.
  zoom(factor, x = this.size[0] / 2, y = this.size[1] / 2) {
    const step = (1 - 1 / factor) / this.scale
    this.target = [this.target[0] + step * (x - this.size[0] / 2), this.target[1] - step * (y - this.size[1] / 2)]
    this.scale *= factor
    this.touched = true
  }

  shows(points, margin) {
    return points.every(p => inside(this.project(p), this.size, margin))
  }

  // Show all points, as large as they can be.
  fit(points, margin) {
    const [xs, ys] = [0, 1].map(i => points.map(p => p[i]))
    this.target = [middle(xs), middle(ys)]
    this.scale = Math.min(...[xs, ys].map((v, i) => Math.max(this.size[i] - 2 * margin, 1) / (Math.max(...v) - Math.min(...v))))
    this.touched = false
  }
}

export const inside = (at, [w, h], margin) => at && at[0] > margin && at[1] > margin && at[0] < w - margin && at[1] < h - margin
export const middle = values => (Math.min(...values) + Math.max(...values)) / 2
