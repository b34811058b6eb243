// From metres to pixels: a plan that can be moved and zoomed, or a camera that circles around a point in space.
import { matTimes, minus, outer } from './log.js'

const NEAR = 0.05 // m; nothing closer to the eye is drawn

export class Camera {
  constructor(d) {
    this.d = d
    this.target = Array(d).fill(0)
    this.size = [100, 100]
    this.scale = 50 // 2D: pixels for a metre
    this.distance = 10 // 3D: from the eye to the target, m
    this.azimuth = -1.05
    this.elevation = 0.5
    this.touched = false // by the user: then it stays where it is
    this.turn(0, 0)
  }

  // Rows: right, down, and in space forward. The plan is a camera from which everything is 1 away.
  turn(azimuth, elevation) {
    this.azimuth += azimuth
    this.elevation = Math.min(Math.max(this.elevation + elevation, -1.5), 1.5)
    const [c, s] = [Math.cos(this.azimuth), Math.sin(this.azimuth)]
    const [C, S] = [Math.cos(this.elevation), Math.sin(this.elevation)]
    this.axes = this.d === 2 ? [[1, 0], [0, -1]] : [[-s, c, 0], [c * S, s * S, -C], [-c * C, -s * C, -S]]
  }

  get focal() {
    return this.d === 2 ? this.scale : 2.2 * Math.min(this.size[0], 1.4 * this.size[1])
  }

  // A point as the camera has it: right, down, away.
  see(p) {
    const v = matTimes(this.axes, minus(p, this.target))
    if (this.d === 2) return [v[0], v[1], 1]
    v[2] += this.distance
    return v
  }

  pixel([x, y, z]) {
    return [this.size[0] / 2 + (this.focal * x) / z, this.size[1] / 2 + (this.focal * y) / z]
  }

  // A point in pixels; null for one behind the eye, or for none.
  project(p) {
    const v = p && this.see(p)
    return v && v[2] > NEAR && v.every(Number.isFinite) ? this.pixel(v) : null
  }

  // The part of a segment in front of the eye, in pixels; null if there is none.
  segment(p, q) {
    let a = this.see(p), b = this.see(q)
    if (!(a[2] > NEAR || b[2] > NEAR)) return null
    const cut = (u, v) => u.map((x, i) => x + ((NEAR - u[2]) / (v[2] - u[2])) * (v[i] - x))
    if (a[2] < NEAR) a = cut(a, b)
    if (b[2] < NEAR) b = cut(b, a)
    return [this.pixel(a), this.pixel(b)]
  }

  // The outline of the k-sigma ellipsoid, exactly: the dual conic C = A A' - a a' of its picture, with A = k axes L and
  // a the centre as seen (Hartley and Zisserman, Multiple View Geometry, sec. 8.3). C / C33 is [[c c' - E, c], [c', 1]]:
  // the ellipse with centre c and (p - c)' inv(E) (p - c) = 1. Null if the eye is not clearly outside.
  outline(p, L, k) {
    const columns = L[0].map((_, j) => L.map(row => k * row[j]))
    const A = this.axes.map(axis => columns.map(column => axis.reduce((sum, v, i) => sum + v * column[i], 0)))
    if (this.d === 2) A.push([0, 0])
    const a = this.see(p), C = outer(A).map((row, i) => row.map((v, j) => v - a[i] * a[j]))
    if (!(a[2] > NEAR && Math.sqrt(C[2][2] + a[2] * a[2]) < 0.95 * a[2])) return null
    const c = [C[0][2] / C[2][2], C[1][2] / C[2][2]], f = this.focal
    const E = [0, 1].map(i => [0, 1].map(j => f * f * (c[i] * c[j] - C[i][j] / C[2][2])))
    const mean = (E[0][0] + E[1][1]) / 2, half = Math.hypot((E[0][0] - E[1][1]) / 2, E[0][1])
    const [major, minor] = [mean + half, mean - half].map(v => Math.sqrt(Math.max(v, 0)))
    const [x, y] = this.pixel([...c, 1])
    return { x, y, major, minor, angle: Math.atan2(2 * E[0][1], E[0][0] - E[1][1]) / 2 }
  }

  // ------------------------------------------------------------------------------------------- what the user can do

  move(dx, dy) {
    const metres = (this.d === 2 ? 1 : this.distance) / this.focal, [right, down] = this.axes
    this.target = this.target.map((v, i) => v - metres * (dx * right[i] + dy * down[i]))
    this.touched = true
  }

  orbit(dx, dy) {
    this.turn(-0.008 * dx, 0.008 * dy)
    this.touched = true
  }

  // Come closer; in the plane the point under [x, y] stays where it is.
  zoom(factor, x = this.size[0] / 2, y = this.size[1] / 2) {
    if (this.d === 2) {
      const from = [x - this.size[0] / 2, y - this.size[1] / 2], step = (1 - 1 / factor) / this.scale
      this.target = [this.target[0] + step * from[0], this.target[1] - step * from[1]]
      this.scale *= factor
    } else {
      this.distance = Math.max(this.distance / factor, 4 * NEAR)
    }
    this.touched = true
  }

  shows(points, margin) {
    return points.every(p => {
      const [x, y] = this.project(p) ?? [-1e9, 0]
      return x > margin && y > margin && x < this.size[0] - margin && y < this.size[1] - margin
    })
  }

  // Show all points, as large as they can be; the direction stays.
  fit(points, margin) {
    this.target = this.target.map((_, i) => middle(points.map(p => p[i])))
    this.touched = false
    for (let round = 0; round < 4; round++) {
      let [near, far] = [1e-3, 1e7] // by bisection of the logarithm
      for (let i = 0; i < 40; i++) {
        const half = Math.sqrt(near * far)
        this.away(half)
        if (this.shows(points, margin)) far = half
        else near = half
      }
      this.away(far)
      if (this.d === 2) return
      const seen = points.map(p => this.project(p)) // in space, the middle of the points is not that of their picture
      this.move(...[0, 1].map(i => this.size[i] / 2 - middle(seen.map(q => q[i]))))
      this.touched = false
    }
  }

  // So many metres from the eye to the target, or in 100 pixels of the plan.
  away(metres) {
    if (this.d === 2) this.scale = 100 / metres
    else this.distance = metres
  }
}

const middle = values => (Math.min(...values) + Math.max(...values)) / 2
