// What is known of one landmark or robot in one frame, in words and numbers.
import { digits, fixed, paragraph, table } from './element.js'
import { mahalanobis, minus, norm, outer, principalAxes } from './log.js'
import { idOf } from './scene.js'

const DEGREES = 180 / Math.PI
const UNITS = { rad: ['°', DEGREES], '': ['', 1] }

export function readout(log, frame, key, withTruth) {
  const k = log.head.k, id = idOf(key), robot = frame.robots.get(id)
  if (robot) {
    const truth = withTruth && frame.truth.get(id), error = truth ? farFrom('true position', robot, truth.p) : []
    return [paragraph(log.robots.get(id).name, 'what'), ...place(robot, k), ...error]
  }
  const lmk = frame.lmks.get(key)
  if (!lmk) return [paragraph(`Landmark ${key}: not in the map`, 'what')]
  const seen = frame.obs.filter(o => o.lmk === key)
  const parts = [paragraph(`Landmark ${key}: ${state(frame, key, seen)}`, 'what'), ...place(lmk, k)]
  parts.push(...seen.flatMap(o => innovation(o, log)))
  if (withTruth && lmk.p) {
    const far = ([, q]) => norm(minus(lmk.p, q)), all = [...frame.world].filter(([, q]) => q)
    const nearest = all.reduce((a, b) => (a && far(a) <= far(b) ? a : b), null)
    if (nearest) parts.push(...farFrom(`nearest true landmark (${nearest[0]})`, lmk, nearest[1]))
  }
  return parts
}

function state(frame, id, seen) {
  if (seen.length) return seen.some(o => o.used) ? 'corrected' : 'rejected'
  if (frame.missed.includes(id)) return 'looked for, not found'
  return frame.fresh.includes(id) ? 'new' : 'not measured'
}

function place({ p, L, heading, std }, k) {
  if (!p) return [paragraph('no finite place')]
  const P = L && outer(L), known = L === undefined || (P && !P.flat().some(Boolean))
  const sigma = i => (known ? 'known' : P ? digits(Math.sqrt(P[i][i]), 2) : 'unknown')
  const rows = p.map((v, i) => [`${'xyz'[i]} (m)`, fixed(v, 2), sigma(i)])
  if (heading !== undefined) rows.push(['heading (°)', fixed(heading * DEGREES, 1), std === null ? sigma(0) : digits(std * DEGREES, 2)])
  const parts = [table(['', 'mean', 'σ'], rows)]
  if (known || !P) return parts
  const pairs = [[0, 1], [0, 2], [1, 2]].filter(([, j]) => j < p.length)
  const rho = pairs.map(([i, j]) => `${'xyz'[i]}${'xyz'[j]} ${fixed(P[i][j] / Math.sqrt(P[i][i] * P[j][j]), 2)}`)
  const axes = principalAxes(P).map(({ value }) => digits(k * Math.sqrt(value), 2))
  return [...parts, paragraph(`correlation ${rho.join(', ')}`), paragraph(`${k}σ half-axes ${axes.join(' × ')} m`)]
}

function innovation(o, log) {
  const rows = o.units.map((unit, i) => {
    const [symbol, factor] = UNITS[unit] ?? [unit, 1], name = `z${o.units.length > 1 ? '₁₂₃₄₅₆'[i] : ''}`
    return [`${name} (${symbol})`, digits(o.nu[i] * o.std[i] * factor, 2), digits(o.std[i] * factor, 2)]
  })
  const by = log.sensors.size > 1 ? `, ${log.sensors.get(o.sen).name}` : ''
  return [table([`innovation${by}`, 'z', 'σ'], rows), paragraph(`d² = ${digits(o.md2)}${o.used ? '' : ': outside the gate'}`)]
}

function farFrom(name, { p, L }, q) {
  if (!p || !q) return []
  const e = minus(p, q), d = L ? mahalanobis(L, e) : NaN
  return [paragraph(`${name}: ${digits(norm(e), 2)} m away${Number.isFinite(d) ? `, ${digits(d, 2)}σ` : ''}`)]
}
