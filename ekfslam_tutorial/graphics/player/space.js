// The picture in space. What has a body stands on the stage, which WebGL draws; marks and words are written over it.
import { matrices, Orbit } from './orbit.js'
import { fixed } from './element.js'
import { cross, matTimes, niceStep, outer, plus, principalAxes } from './log.js'
import { decimals, idOf, multiples, Scene } from './scene.js'
import { Stage } from './stage.js'

const GLASS = 0.3, FAINT = 0.06 // how much of what is behind an ellipsoid it hides; a large one would hide everything

export class Space extends Scene {
  constructor(canvas, log, options) {
    super(canvas, log, options, new Orbit())
    this.stage = new Stage()
    this.stage.form('robot', options.bodies.robot)
    this.stage.form('view', [0, 1, 2, 3].map(i => [[0, 0, 0], CORNERS[i], CORNERS[(i + 1) % 4]]))
    this.views = [...log.sensors.values()].filter(sensor => sensor.view)
  }

  resize(width, height, font) {
    super.resize(width, height, font)
    this.stage.resize(width, height, this.ratio)
    const { camera } = this
    if (!camera.touched) camera.turn(0, Math.min(Math.max(0.5, 0.6 * (height / width) + 0.2), 0.9) - camera.elevation)
  }

  // For the pictures of the cameras.
  room() {
    const [W, H] = this.area, h = this.views.map(({ view }) => view[1] / view[0])
    this.inset = Math.min(0.2 * W, 210, (H - 6 * (h.length + 1)) / h.reduce((a, b) => a + b, 0))
    return this.stage.gl && this.shown.view && W >= 420 ? this.inset + 12 : 0
  }

  frameOf(low, high, points) {
    const span = Math.max(high[0] - low[0], high[1] - low[1])
    const step = niceStep(span / 8), [xs, ys] = [0, 1].map(i => multiples(step, low[i] - step / 2, high[i] + step / 2))
    this.floor = { step, xs, ys, z: Math.min(Math.max(0, low[2]), high[2]) }
    this.span = span
    for (const x of [xs[0], xs.at(-1)]) for (const y of [ys[0], ys.at(-1)]) points.push([x, y, this.floor.z])
    return 4 * Math.min(this.scale, 1) * this.font
  }

  // ------------------------------------------------------------------------------------------------ on the stage

  background(i, frame, states, chosen) {
    const { stage, shown, camera, context } = this
    stage.clear()
    stage.lines(this.grid(), 0)
    if (frame) {
      stage.lines(this.trails(i), 0)
      stage.shapes('robot', this.robots(frame), 0)
      if (shown.fan) stage.shapes('view', this.pyramids(frame), 1)
      stage.lines([...this.stems(frame), ...this.edges(frame), ...this.lines(frame, states), ...this.sights(frame), ...this.ringLines(frame, chosen)], 0)
      if (shown.ellipse) stage.shapes('ball', this.ellipsoids(frame, states), 2)
    }
    if (stage.gl) {
      stage.draw(camera.view(), camera.size)
      const { height } = stage.canvas, [w, h] = camera.size.map(v => v * this.ratio)
      context.drawImage(stage.canvas, 0, height - h, w, h, 0, 0, ...camera.size)
    } else {
      this.text('Without WebGL, which this browser does not offer, there are marks and words only.', [8, 2.2 * this.font], '#222', 'left')
    }
    this.coordinates()
  }

  grid() {
    const { xs, ys, z } = this.floor, look = { color: '#D9D9D9', width: 1 }
    return [
      ...xs.map(x => ({ from: [x, ys[0], z], to: [x, ys.at(-1), z], ...look })),
      ...ys.map(y => ({ from: [xs[0], y, z], to: [xs.at(-1), y, z], ...look })),
    ]
  }

  // Estimated paths up to now, and the true ones dashed.
  trails(last) {
    const rows = [], { frames, robots } = this.log
    for (const [key, dash] of [['robots', 0], ['truth', this.size]]) {
      if (dash && !this.shown.truth) continue
      for (const id of robots.keys()) {
        let before = 0
        for (let i = 1; i <= last; i++) {
          const from = frames[i - 1][key].get(id)?.p, to = frames[i][key].get(id)?.p
          if (!from || !to) continue
          rows.push({ from, to, color: dash ? this.styles.truth.color : this.color(id), width: dash ? 2 : 3, dash, before })
          before += Math.hypot(...from.map((v, n) => v - to[n]))
        }
      }
    }
    return rows
  }

  robots(frame) {
    return [...frame.robots].filter(([, { p }]) => p).map(([id, pose]) => ({ ...placed(pose, this.size), color: this.color(id) }))
  }

  ellipsoids(frame, states) {
    const { styles, k, span } = this, rows = []
    const add = ({ p, L }, color) => {
      if (!p || !L || !L.flat().some(Boolean)) return
      const parts = principalAxes(outer(L)), [a, b] = parts.map(({ vector }) => vector)
      const lengths = parts.map(({ value }) => Math.min(k * Math.sqrt(value), 20 * span)), least = lengths[0] / 1e4
      if (!Number.isFinite(lengths[0])) return
      const directions = [a, b, cross(a, b)] // right-handed: what is outside stays outside
      const axes = directions.map((u, i) => u.map(v => v * Math.max(lengths[i], least)))
      rows.push({ axes, centre: p, color, alpha: lengths[0] > span / 4 ? FAINT : GLASS })
    }
    for (const [id, robot] of frame.robots) add(robot, this.color(id))
    for (const [id, lmk] of frame.lmks) {
      const state = states.get(id)
      add(lmk, ((state !== 'missed' && styles[state]) || styles.estimate).color)
    }
    for (const [id, ends] of frame.lines) {
      for (const end of ends) add(end, ((states.get(id) !== 'missed' && styles[states.get(id)]) || styles.estimate).color)
    }
    return rows
  }

  // What a camera can see, near its eye: a pyramid of glass.
  pyramids(frame) {
    return this.eyes(frame).map(({ pose, half, color }) => ({ ...placed(pose, 1, half.map(v => v * this.reach)), color, alpha: 0.12 }))
  }

  eyes(frame) {
    return [...this.log.sensors.values()].flatMap(sensor => {
      const pose = this.log.sensorPose(frame, sensor.id)
      return pose ? [{ sensor, pose, half: [...(sensor.view ?? [0.6, 0.45]), 1], color: this.color(sensor.robot) }] : []
    })
  }

  get reach() {
    return 2.4 * this.size
  }

  // Edges of the pyramids, with a mark on their upper side, and of the true robots.
  edges(frame) {
    const rows = []
    if (this.shown.fan) {
      for (const { pose, half, color } of this.eyes(frame)) {
        const at = v => plus(pose.p, matTimes(pose.R, v.map((x, i) => x * half[i] * this.reach)))
        const join = (a, b) => rows.push({ from: at(a), to: at(b), color, width: 1.5 })
        CORNERS.forEach((corner, i) => (join([0, 0, 0], corner), join(corner, CORNERS[(i + 1) % 4])))
        join([-0.4, -1.1, 1], [0, -1.7, 1]), join([0, -1.7, 1], [0.4, -1.1, 1]), join([0.4, -1.1, 1], [-0.4, -1.1, 1])
      }
    }
    if (this.shown.truth) {
      for (const { p, R } of frame.truth.values()) {
        if (!p) continue
        for (const face of this.bodies.robot) {
          const corners = face.map(v => plus(p, matTimes(R, v.map(x => x * this.size))))
          corners.forEach((from, i) => rows.push({ from, to: corners[(i + 1) % corners.length], color: this.styles.truth.color, width: 1.3 }))
        }
      }
    }
    return rows
  }

  // Lines between their ends, in the colour of their state; the true edges thin and dark.
  lines(frame, states) {
    const { styles } = this, rows = []
    for (const [id, [a, b]] of frame.lines) {
      const state = states.get(id)
      rows.push({ from: a.p, to: b.p, color: ((state !== 'missed' && styles[state]) || styles.estimate).color, width: 3 })
    }
    if (this.shown.truth) for (const [from, to] of frame.edges.values()) rows.push({ from, to, color: styles.truth.color, width: 1.2 })
    return rows
  }

  // From each landmark down to the floor: there it stands.
  stems(frame) {
    const all = [...frame.lmks.values()].filter(({ p }) => p)
    return all.map(({ p }) => ({ from: p, to: [p[0], p[1], this.floor.z], color: '#BDBDBD', width: 1 }))
  }

  // From the eye to what it measured, in the colour of the robot; to what the gate rejected, in that of the rejected.
  sights(frame) {
    if (!this.shown.measurement) return []
    return this.measured(frame).map(({ o, from, to }) => ({
      from, to, color: o.used ? this.color(this.log.sensors.get(o.sen).robot) : this.styles.rejected.color,
      width: o.used ? 1.2 : 2.2, alpha: o.used ? 0.6 : 1,
    }))
  }

  // The great circles of the ellipsoid that is being read.
  ringLines(frame, chosen) {
    const { p, L } = frame.lmks.get(chosen) ?? frame.robots.get(idOf(chosen)) ?? {}
    if (!p || !L) return []
    const axes = principalAxes(outer(L)).map(({ value, vector }) => vector.map(v => this.k * Math.sqrt(value) * v))
    return [[0, 1], [1, 2], [2, 0]].flatMap(([a, b]) => {
      const round = t => p.map((v, i) => v + Math.cos(t) * axes[a][i] + Math.sin(t) * axes[b][i])
      return Array.from({ length: 48 }, (_, n) => ({ from: round((n * Math.PI) / 24), to: round(((n + 1) * Math.PI) / 24), color: '#222222', width: 1.6 }))
    })
  }

  // ------------------------------------------------------------------------------------------------- over the stage

  // The coordinates along the nearer edges of the floor.
  coordinates() {
    const { camera } = this, { step, xs, ys, z } = this.floor, at = (x, y) => [x, y, z]
    const [mx, my] = [xs, ys].map(t => (t[0] + t.at(-1)) / 2), away = p => camera.see(p)[2]
    const ny = away(at(mx, ys[0])) < away(at(mx, ys.at(-1))) ? [ys[0], -step] : [ys.at(-1), step]
    const nx = away(at(xs[0], my)) < away(at(xs.at(-1), my)) ? [xs[0], -step] : [xs.at(-1), step]
    const digits = decimals(step)
    const label = (words, p, color) => {
      const q = camera.project(p)
      if (q) this.text(words, q, color, 'center')
    }
    for (const x of xs) label(fixed(x, digits), at(x, ny[0] + 0.45 * ny[1]), '#555')
    for (const y of ys) label(fixed(y, digits), at(nx[0] + 0.45 * nx[1], y), '#555')
    label('x (m)', at(mx + step / 2, ny[0] + 1.15 * ny[1]), '#222')
    label('y (m)', at(nx[0] + 1.15 * nx[1], my + step / 2), '#222')
    this.text(`one square: ${Number(step.toPrecision(1))} m`, [4, 0.9 * this.font], '#222', 'left')
  }

  // Robots are bodies: they stand on the stage already.
  body() {}

  // What each camera sees, one picture below the other at the right: the estimated map, and what was measured in it.
  foreground(frame, states) {
    const { stage, context, font } = this, w = Math.round(this.inset), left = this.area[0] - w - 6
    if (!this.room()) return
    let top = 6
    for (const { id, name, robot, view } of this.views) {
      const h = Math.round((w * view[1]) / view[0]), pose = this.log.sensorPose(frame, id)
      if (!pose) continue
      const axes = [0, 1, 2].map(j => pose.R.map(row => row[j]))
      stage.draw(matrices(axes, pose.p, view, this.reach * 1.05, 50 * this.span), [w, h])
      const { width, height } = stage.canvas, ratio = stage.renderer.dpr
      context.drawImage(stage.canvas, 0, height - h * ratio, w * ratio, h * ratio, left, top, w, h)
      context.save()
      context.beginPath()
      context.rect(left, top, w, h)
      context.clip()
      for (const [lmk, { p }] of frame.lmks) {
        const [x, y, z] = p ? matTimes(axes, p.map((v, i) => v - pose.p[i])) : [0, 0, 0]
        if (!(z > 0)) continue
        const state = states.get(lmk), mine = frame.obs.some(o => o.lmk === lmk && o.sen === String(id))
        const at = [left + w / 2 + ((x / z / view[0]) * w) / 2, top + h / 2 + ((y / z / view[1]) * h) / 2]
        this.marker((mine && this.styles[state]) || this.styles.estimate, at, mine ? 0.9 : 0.5)
      }
      context.restore()
      this.style({ color: this.color(robot) }, 2)
      context.strokeRect(left, top, w, h)
      this.text(name, [left + 5, top + 0.8 * font], '#222', 'left')
      top += h + 6
    }
  }
}

const CORNERS = [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]

// A shape in the frame of a pose, `size` times as large, along each axis `half` times.
function placed({ p, R }, size, half = [1, 1, 1]) {
  return { centre: p, axes: [0, 1, 2].map(j => R.map(row => row[j] * size * half[j])), alpha: 1 }
}
