// The picture: floor, paths, robots, landmarks with their covariances, measurements. What a colour and a shape mean
// comes from Python (graphics/style.py), in the options `styles` and `robots`. This is the picture of a plane; that of
// space is another background with the same marks over it (space.js).
import { Plan } from './camera.js'
import { fixed } from './element.js'
import { matTimes, niceStep, plus } from './log.js'
import { HALO, Pen } from './pen.js'

export class Scene extends Pen {
  constructor(canvas, log, { styles, bodies, robots }, camera = new Plan()) {
    super(canvas.getContext('2d'), camera)
    Object.assign(this, { canvas, log, styles, bodies, palette: robots, k: log.head.k, shown: {} })
    this.items = [] // what the pointer can find: {key, x, y}
  }

  resize(width, height, font) {
    const ratio = window.devicePixelRatio || 1
    Object.assign(this.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) })
    this.area = [width, height]
    this.camera.size = [width - this.room(), height]
    Object.assign(this, { ratio, font, scale: Math.min(Math.max(Math.min(width, 1.4 * height) / 700, 0.65), 1.3) })
  }

  // What stands at the right of the picture, pixels.
  room() {
    return 0
  }

  // Points that the picture should hold: paths, true landmarks, and the estimates that know where they are.
  contents() {
    const last = this.log.frames.at(-1), points = []
    for (const frame of this.log.frames) {
      for (const { p } of [...frame.robots.values(), ...frame.truth.values()]) if (p) points.push(p)
    }
    const from = points.at(-1) ?? Array(this.log.d).fill(0)
    for (const p of last?.world.values() ?? []) if (p) points.push(p)
    for (const ends of last?.edges.values() ?? []) points.push(...ends)
    for (const { p, L } of last?.lmks.values() ?? []) {
      if (p && L && this.k * Math.hypot(...L.flat()) < 0.5 * Math.hypot(...p.map((v, i) => v - from[i]))) points.push(p)
    }
    const middle = points.length ? points[0] : from
    return [...points, middle.map(v => v - 1), middle.map(v => v + 1)]
  }

  fit(always = true) {
    const points = this.contents(), low = [], high = []
    for (let i = 0; i < this.log.d; i++) {
      low.push(Math.min(...points.map(p => p[i])))
      high.push(Math.max(...points.map(p => p[i])))
    }
    const span = Math.max(high[0] - low[0], high[1] - low[1])
    this.size = span / 30 // half a robot, as in MapFig
    const margin = this.frameOf(low, high, points)
    if (always || !this.camera.shows(points, 0)) this.camera.fit(points, margin)
  }

  // Room for the numbers at the borders, pixels.
  frameOf() {
    return 3 * this.font
  }

  // Each robot has a colour of its own.
  color(id) {
    return this.palette[[...this.log.robots.keys()].indexOf(id) % this.palette.length] ?? this.styles.estimate.color
  }

  // ---------------------------------------------------------------------------------------------------- one frame

  draw(i, chosen) {
    const { context, camera, log, ratio } = this, frame = log.frames[i]
    context.setTransform(ratio, 0, 0, ratio, 0, 0)
    context.clearRect(0, 0, ...this.area)
    context.lineJoin = 'round'
    Object.assign(this, { items: [], at: i })
    const states = new Map(frame?.missed.map(id => [id, 'missed']))
    for (const o of frame?.obs ?? []) if (states.get(o.lmk) !== 'updated') states.set(o.lmk, o.used ? 'updated' : 'rejected')
    this.background(i, frame, states, chosen)
    if (!frame) return
    if (this.shown.measurement) this.measurements(frame)
    if (this.shown.truth) this.truth(frame)
    for (const [id, robot] of frame.robots) this.robot(id, robot)
    this.landmarks(frame, states)
    this.ring(chosen)
    this.names()
    this.foreground(frame, states)
  }

  background(i, frame, states) {
    this.plan()
    if (!frame) return
    if (this.shown.fan) this.fans(frame)
    if (this.shown.truth) this.path(i, 'truth')
    this.path(i, 'robots')
    if (this.shown.ellipse) this.ellipses(frame, states)
    if (this.shown.measurement) this.sights(frame)
  }

  foreground() {}

  plan() {
    const { context, camera, font } = this, [w, h] = camera.size, step = niceStep((6.5 * font) / camera.scale)
    const digits = decimals(step)
    const [x0, y0] = camera.target, reach = [w / 2 / camera.scale, h / 2 / camera.scale]
    this.style({ color: '#D9D9D9' }, 1)
    const xs = multiples(step, x0 - reach[0], x0 + reach[0]), ys = multiples(step, y0 - reach[1], y0 + reach[1])
    context.beginPath()
    for (const x of xs) this.straight([camera.project([x, y0])[0], 0], [camera.project([x, y0])[0], h])
    for (const y of ys) this.straight([0, camera.project([x0, y])[1]], [w, camera.project([x0, y])[1]])
    context.stroke()
    for (const x of xs) {
      const at = camera.project([x, y0])[0]
      if (at > 2 * font && at < w - 1.5 * font) this.text(fixed(x, digits), [at, h - 0.8 * font], '#555', 'center')
    }
    for (const y of ys) {
      const at = camera.project([x0, y])[1]
      if (at > 2 * font && at < h - 2 * font) this.text(fixed(y, digits), [4, at], '#555', 'left')
    }
    this.text('x (m)', [w - 4, h - 2.2 * font], '#222', 'right')
    this.text('y (m)', [4, 0.9 * font], '#222', 'left')
  }

  // What a sensor in the plane can see.
  fans(frame) {
    const { context, camera, log } = this
    for (const { id, robot, fov, reach } of log.sensors.values()) {
      const pose = reach && log.sensorPose(frame, id), at = pose && camera.project(pose.p)
      if (!at) continue
      const half = Math.min(fov ?? 2 * Math.PI, 2 * Math.PI) / 2, heading = Math.atan2(pose.R[1][0], pose.R[0][0])
      context.beginPath()
      if (half < Math.PI) context.moveTo(...at)
      context.arc(...at, reach * camera.scale, -heading - half, -heading + half)
      context.closePath()
      this.style({ color: this.by(robot, this.styles.measurement) }, 1)
      context.globalAlpha = 0.07
      context.fill()
      context.globalAlpha = 0.35
      context.stroke()
      context.globalAlpha = 1
    }
  }

  path(last, key) {
    const { context, log } = this
    for (const id of log.robots.keys()) {
      this.style(key === 'truth' ? this.styles.truth : { color: this.color(id) }, 2)
      context.beginPath()
      for (let i = 1; i <= last; i++) {
        const p = log.frames[i - 1][key].get(id)?.p, q = log.frames[i][key].get(id)?.p
        if (p && q) this.segment(p, q)
      }
      context.stroke()
    }
  }

  ellipses(frame, states) {
    const { styles } = this
    for (const [id, { p, L }] of frame.robots) this.ellipse(p, L, { color: this.color(id) }, 1.5)
    for (const [id, { p, L }] of frame.lmks) {
      const state = states.get(id), style = (state !== 'missed' && styles[state]) || styles.estimate
      this.ellipse(p, L, style, style === styles.estimate ? 1.3 : 2.2)
    }
  }

  // The k-sigma ellipse.
  ellipse(p, L, style, width) {
    const { context, camera } = this
    if (!p || !L || !L.flat().some(Boolean)) return
    const o = camera.outline(p, L, this.k)
    if (!(o.major < 1e5)) return
    this.style(style, width)
    context.beginPath()
    context.ellipse(o.x, o.y, o.major, o.minor, o.angle, 0, 2 * Math.PI)
    const large = o.major > Math.max(...camera.size) / 3 // it would cover the others
    context.globalAlpha = large ? 0.02 : 0.1
    context.fill()
    context.globalAlpha = large ? 0.45 : 1
    context.stroke()
    context.globalAlpha = 1
  }

  // The colour of a robot where there are several, else that of the style.
  by(robot, style) {
    return this.log.robots.size > 1 ? this.color(robot) : style.color
  }

  // From the sensor to the measured point; a direction ends at the landmark that it is meant for.
  measured(frame) {
    return frame.obs.flatMap(o => {
      const from = this.log.sensorPose(frame, o.sen)?.p, to = o.point ?? frame.lmks.get(o.lmk)?.p
      return from && to ? [{ o, from, to }] : []
    })
  }

  sights(frame) {
    const { context, log, styles } = this
    for (const { o, from, to } of this.measured(frame)) {
      const color = o.used ? this.by(log.sensors.get(o.sen).robot, styles.measurement) : styles.rejected.color
      this.style({ ...styles.measurement, color }, o.used ? 1.4 : 2)
      context.beginPath()
      this.segment(from, to)
      context.stroke()
    }
  }

  measurements(frame) {
    for (const { o } of this.measured(frame)) {
      const end = this.camera.project(o.point)
      if (end) this.marker(o.used ? this.styles.measurement : this.styles.rejected, end, 1.15)
    }
  }

  truth(frame) {
    for (const p of frame.world.values()) {
      const at = this.camera.project(p)
      if (at) this.marker(this.styles.truth, at)
    }
    for (const pose of frame.truth.values()) if (pose.p) this.body(this.bodies.robot, this.size, pose, this.styles.truth)
  }

  robot(id, pose) {
    const { log } = this, style = { color: this.color(id) }
    if (!pose.p) return
    this.body(this.bodies.robot, this.size, pose, style, 0.55)
    for (const sensor of log.sensors.values()) {
      if (sensor.robot !== id) continue
      const at = log.sensorPose(log.frames[this.at], sensor.id)
      if (at) this.body(this.bodies.sensor, 0.9 * this.size, at, style, 0.3)
    }
    const at = this.camera.project(pose.p)
    if (at) this.items.push({ key: `robot ${id}`, x: at[0], y: at[1] })
  }

  // Faces in the frame of a robot or a sensor.
  body(faces, size, { p, R }, style, alpha = 0) {
    const { context, camera } = this
    this.style({ color: style.color }, alpha ? 1.2 : 1.6)
    for (const face of faces) {
      const corners = face.map(v => camera.project(plus(p, matTimes(R, v.map(x => size * x)))))
      if (corners.some(c => !c)) continue
      context.beginPath()
      corners.forEach((c, i) => (i ? context.lineTo(...c) : context.moveTo(...c)))
      context.closePath()
      context.globalAlpha = alpha
      if (alpha) context.fill()
      context.globalAlpha = 1
      context.stroke()
    }
  }

  landmarks(frame, states) {
    const { styles, camera } = this
    for (const [id, { p }] of frame.lmks) {
      const at = camera.project(p)
      if (!at) continue
      const state = states.get(id)
      this.marker(state === 'updated' ? styles.updated : styles.estimate, at)
      if (state === 'rejected') this.marker(styles.rejected, at, 1.5)
      if (state === 'missed') this.marker(styles.predicted, at, 1.6)
      if (frame.fresh.includes(id)) this.circle(at, 8.5 * this.scale, styles.estimate)
      this.items.push({ key: id, x: at[0], y: at[1] })
    }
    for (const p of frame.lost) {
      const at = camera.project(p)
      if (at) this.marker(styles.deleted, at, 1.4)
    }
  }

  names() {
    if (!this.shown.name) return
    for (const { key, x, y } of this.items) {
      if (typeof key === 'number') this.text(key, [x + 7 * this.scale, y - 8 * this.scale], '#000', 'left')
      else if (this.log.robots.size > 1) this.text(this.log.robots.get(idOf(key)).name, [x + 12, y - 12], this.color(idOf(key)), 'left', 'bold ')
    }
  }

  // Round the landmark or robot that is being read.
  ring(chosen) {
    const item = this.items.find(({ key }) => key === chosen)
    if (!item) return
    this.circle([item.x, item.y], 14 * this.scale, { color: HALO }, 6)
    this.circle([item.x, item.y], 14 * this.scale, { color: '#000' }, 2.5)
  }

  // The nearest thing to a pixel, not further than `reach`.
  find(x, y, reach = 16) {
    const far = item => Math.hypot(item.x - x, item.y - y)
    const best = this.items.reduce((a, b) => (a && far(a) <= far(b) ? a : b), null)
    return best && far(best) <= reach ? best.key : null
  }
}

export const decimals = step => Math.max(0, -Math.floor(Math.log10(step) + 1e-9))

export function multiples(step, low, high) {
  const first = Math.ceil(low / step - 1e-9), n = Math.floor(high / step + 1e-9) - first
  return Array.from({ length: n + 1 }, (_, i) => step * (first + i))
}

// The id in the key of a robot.
export const idOf = key => (typeof key === 'string' ? Number(key.slice(6)) : null)
