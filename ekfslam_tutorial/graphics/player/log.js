// A state log, read: what is known in each frame, in metres and radians. The class StateLog describes the format.

const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0)
export const matTimes = (M, v) => M.map(row => dot(row, v))
export const plus = (a, b) => a.map((v, i) => v + b[i])
export const minus = (a, b) => a.map((v, i) => v - b[i])
export const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d]
export const norm = a => Math.hypot(...a)
export const outer = (L, M = L) => L.map(row => M.map(other => dot(row, other))) // L M'

export class Log {
  constructor(data) {
    this.head = data
    this.d = data.dim
    this.sensors = new Map(data.sensors.map(sensor => [String(sensor.id), sensor]))
    this.robots = new Map(data.robots.map(robot => [robot.id, robot]))
    this.frames = []
    data.frames.forEach(record => this.add(record))
  }

  // Read the next record; it says only what has changed since the one before.
  add(record) {
    const { d } = this, n = d === 2 ? 3 : 7, last = this.frames.at(-1), before = record.whole ? {} : last ?? {}
    const rows = key => record[key] ?? []
    const poses = key => rows(key).map(([id, ...x]) => [id, this.pose(x)])
    const lmks = new Map(before.lmks)
    const lost = rows('gone').map(id => last?.lmks.get(id)?.p).filter(Boolean)
    rows('gone').forEach(id => lmks.delete(id))
    const lines = new Map(before.lines)
    rows('gone').forEach(id => lines.delete(id))
    for (const [id, ...x] of rows('lin')) lines.set(id, this.line(x))
    for (const [id, ...x] of rows('lmk')) lmks.set(id, this.landmark(x, lmks.get(id)))
    this.frames.push({
      k: record.k,
      t: record.t,
      robots: new Map(rows('rob').map(([id, ...x]) => [id, { ...this.pose(x), ...this.spread(x.slice(n)) }])),
      truth: new Map(poses('true')),
      sens: new Map([...before.sens ?? [], ...poses('sen')]),
      lmks,
      lines,
      edges: new Map([...before.edges ?? [], ...rows('edge').map(([id, ...x]) => [id, [this.point(x), this.point(x.slice(3))]])]),
      world: new Map([...before.world ?? [], ...rows('world').map(([id, ...x]) => [id, this.point(x)])]),
      obs: [...this.observations(record.used, true), ...this.observations(record.rejected, false)],
      missed: Object.values(record.missed ?? {}).flat(),
      fresh: rows('new'),
      lost,
      notes: rows('note'),
      image: record.img ? { src: record.img, k: record.k } : before.image,
    })
  }

  point(x) {
    return x.length < this.d ? null : x.slice(0, this.d).map(v => v * this.head.units.m)
  }

  pose(x) {
    const p = this.point(x), [a, b, c, e] = x.slice(this.d).map(v => v * this.head.units.rad)
    if (!p) return { p }
    if (this.d === 2) {
      return { p, heading: a, R: [[Math.cos(a), -Math.sin(a)], [Math.sin(a), Math.cos(a)]] }
    }
    const s = 2 / (a * a + b * b + c * c + e * e) // rounding has left the quaternion a little off unit length
    const R = [
      [1 - s * (c * c + e * e), s * (b * c - a * e), s * (b * e + a * c)],
      [s * (b * c + a * e), 1 - s * (b * b + e * e), s * (c * e - a * b)],
      [s * (b * e - a * c), s * (c * e + a * b), 1 - s * (b * b + c * c)],
    ]
    return { p, R }
  }

  // The lower triangle of L, with L L' the covariance; null where that is not known.
  factor([e, ...low]) {
    if (e === null || e === undefined) return null
    const L = Array.from({ length: this.d }, () => Array(this.d).fill(0))
    for (let i = 0, n = 0; i < this.d; i++) for (let j = 0; j <= i; j++) L[i][j] = low[n++] * 2 ** e
    return L
  }

  spread(x) {
    return { L: this.factor(x), std: this.d === 2 && x.length ? x.at(-1) * this.head.units.rad : null }
  }

  landmark(x, before) {
    const step = this.point(x)
    if (!step) return { p: null, L: null }
    return {
      p: before?.p ? plus(before.p, step) : step,
      L: x.length > this.d ? this.factor(x.slice(this.d)) : before?.L ?? null,
    }
  }

  // Both ends of a line.
  line(x) {
    const n = 6 + (x.length - 6) / 2
    return [
      { p: this.point(x), L: this.factor(x.slice(6, n)) },
      { p: this.point(x.slice(3)), L: this.factor(x.slice(n)) },
    ]
  }

  observations(record, used) {
    return Object.entries(record ?? {}).flatMap(([sen, rows]) => {
      const { units } = this.sensors.get(sen), m = units.length
      return rows.map(([lmk, md2, ...x]) => {
        const std = x.slice(m, 2 * m), nu = x.slice(0, m).map(v => (v === null ? NaN : v / 100))
        return { sen, lmk, used, units, md2: md2 === null ? NaN : md2 / 100, nu, std, point: this.point(x.slice(2 * m)) }
      })
    })
  }

  // A sensor in the world: on its robot, as estimated.
  sensorPose(frame, id) {
    const robot = frame.robots.get(this.sensors.get(String(id)).robot), sensor = frame.sens.get(Number(id))
    if (!robot?.p || !sensor) return null
    const R = robot.R.map(row => robot.R[0].map((_, j) => row.reduce((sum, v, i) => sum + v * sensor.R[i][j], 0)))
    return { p: plus(robot.p, matTimes(robot.R, sensor.p)), R }
  }
}

// Principal axes of a symmetric matrix by Jacobi's rotations: [{value, vector}], greatest first.
export function principalAxes(P) {
  const n = P.length, A = P.map(row => [...row]), V = P.map((_, i) => P.map((_, j) => Number(i === j)))
  for (let sweep = 0; sweep < 12; sweep++) {
    for (let p = 0; p < n; p++) {
      for (let q = p + 1; q < n; q++) {
        if (Math.abs(A[p][q]) < 1e-300) continue
        const angle = 0.5 * Math.atan2(2 * A[p][q], A[q][q] - A[p][p]), c = Math.cos(angle), s = Math.sin(angle)
        const turn = M => M.forEach(row => ([row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]]))
        turn(A)
        for (let j = 0; j < n; j++) [A[p][j], A[q][j]] = [c * A[p][j] - s * A[q][j], s * A[p][j] + c * A[q][j]]
        turn(V)
      }
    }
  }
  const axes = P.map((_, i) => ({ value: Math.max(A[i][i], 0), vector: V.map(row => row[i]) }))
  return axes.sort((a, b) => b.value - a.value)
}

// How far e is from 0 in units of its standard deviation: |inv(L) e|; NaN where L is singular.
export function mahalanobis(L, e) {
  const y = []
  L.forEach((row, i) => y.push((e[i] - dot(row.slice(0, i), y)) / row[i]))
  return norm(y)
}

// 1, 2 or 5 times a power of ten, not less than x.
export function niceStep(x) {
  const power = 10 ** Math.floor(Math.log10(x))
  return power * [1, 2, 5, 10].find(m => m * power >= x * (1 - 1e-9))
}
