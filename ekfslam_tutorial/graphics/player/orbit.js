// From metres to pixels in space: a camera that circles around a point, and the one of a robot.
import { inside, middle } from './camera.js'
import { matTimes, minus } from './log.js'

const NEAR = 0.05 // m; nothing closer to the eye is drawn

export class Orbit {
  constructor() {
    this.target = [0, 0, 0]
    this.size = [100, 100]
    this.distance = 10 // from the eye to the target, m
    this.azimuth = -1.05
    this.elevation = 0.5
    this.touched = false // by the user: then it stays where it is
    this.turn(0, 0)
  }

  // Rows: right, down, forward.
  turn(azimuth, elevation) {
    this.azimuth += azimuth
    this.elevation = Math.min(Math.max(this.elevation + elevation, -1.5), 1.5)
    const [c, s] = [Math.cos(this.azimuth), Math.sin(this.azimuth)]
    const [C, S] = [Math.cos(this.elevation), Math.sin(this.elevation)]
    this.axes = [[-s, c, 0], [c * S, s * S, -C], [-c * C, -s * C, -S]]
  }

  get focal() {
    return 2.2 * Math.min(this.size[0], 1.4 * this.size[1])
  }

  // A point as the eye has it: right, down, away.
  see(p) {
    const [x, y, z] = matTimes(this.axes, minus(p, this.target))
    return [x, y, z + this.distance]
  }

  // A point in pixels; null for one behind the eye, or for none.
  project(p) {
    const [x, y, z] = p ? this.see(p) : [NaN, NaN, NaN]
    const at = [this.size[0] / 2 + (this.focal * x) / z, this.size[1] / 2 + (this.focal * y) / z]
    return z > NEAR && at.every(Number.isFinite) ? at : null
  }

  // What WebGL needs.
  view() {
    const [w, h] = this.size, eye = this.target.map((v, i) => v - this.distance * this.axes[2][i])
    return matrices(this.axes, eye, [w / 2 / this.focal, h / 2 / this.focal], Math.max(this.distance / 500, NEAR / 5), this.distance * 50 + 100)
  }

  move(dx, dy) {
    const metres = this.distance / this.focal, [right, down] = this.axes
    this.target = this.target.map((v, i) => v - metres * (dx * right[i] + dy * down[i]))
    this.touched = true
  }

  orbit(dx, dy) {
    this.turn(-0.008 * dx, 0.008 * dy)
    this.touched = true
  }

  zoom(factor) {
    this.distance = Math.max(this.distance / factor, 4 * NEAR)
    this.touched = true
  }

  shows(points, margin) {
    return points.every(p => inside(this.project(p), this.size, margin))
  }

  // Show all points, as large as they can be; the direction stays.
  fit(points, margin) {
    this.target = this.target.map((_, i) => middle(points.map(p => p[i])))
    for (let round = 0; round < 4; round++) {
      let [near, far] = [1e-3, 1e7] // by bisection of the logarithm
      for (let i = 0; i < 40; i++) {
        this.distance = Math.sqrt(near * far)
        if (this.shows(points, margin)) far = this.distance
        else near = this.distance
      }
      this.distance = far
      const seen = points.map(p => this.project(p)) // the middle of the points is not that of their picture
      this.move(...[0, 1].map(i => this.size[i] / 2 - middle(seen.map(q => q[i]))))
    }
    this.touched = false
  }
}

// View and projection, by columns, of an eye whose axes are right, down, forward; `half` is half the picture at
// distance 1. WebGL's own axes are right, up, backward.
export function matrices([right, down, away], eye, half, near, far) {
  const rows = [right, down.map(v => -v), away.map(v => -v)]
  const shift = matTimes(rows, eye).map(v => -v)
  const view = [...[0, 1, 2].flatMap(j => [...rows.map(row => row[j]), 0]), ...shift, 1]
  const depth = far - near
  const projection = [1 / half[0], 0, 0, 0, 0, 1 / half[1], 0, 0, 0, 0, -(far + near) / depth, -1, 0, 0, (-2 * far * near) / depth, 0]
  return { view, projection }
}
