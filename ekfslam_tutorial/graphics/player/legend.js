// The legend: what is drawn, and how. An entry with a layer is a button that shows and hides it.
import { element } from './element.js'
import { drawMarker } from './pen.js'

const W = 34, H = 18 // of a sample, pixels

export function makeLegend({ styles, robots, sigma }, log, shown, changed) {
  const { frames, d, sensors } = log
  const some = test => frames.length === 0 || frames.some(test) // a live view does not know yet
  const fans = d === 3 ? sensors.size > 0 : [...sensors.values()].some(sensor => sensor.reach)
  const views = d === 3 && [...sensors.values()].some(sensor => sensor.view)
  const names = [...log.robots.values()].map(({ name }, i) => [log.robots.size > 1 ? name : 'estimated path, robot', [[line, { color: robots[i % robots.length] }]]])
  const entries = [
    // words, how, layer, is there any
    ...names,
    ['estimated landmark', [[drawMarker, styles.estimate]]],
    ['id of a landmark', [[name, styles.estimate]], 'name'],
    ['truth', [[line, styles.truth], [drawMarker, styles.truth]], 'truth', some(f => f.truth.size || f.world.size)],
    [sigma, [[ellipse, styles.estimate]], 'ellipse'],
    ['corrected in this frame', [[ellipse, styles.updated], [drawMarker, styles.updated]]],
    ['rejected by the gate', [[ellipse, styles.rejected], [drawMarker, styles.rejected]], '', some(f => f.obs.some(o => !o.used))],
    ['measurement', [[line, styles.measurement], [drawMarker, styles.measurement]], 'measurement'],
    ['looked for, not found', [[drawMarker, styles.predicted]], '', some(f => f.missed.length)],
    ['new in this frame', [[drawMarker, styles.estimate], [ring, styles.estimate]]],
    ['deleted in this frame', [[drawMarker, styles.deleted]], '', some(f => f.lost.length)],
    [d === 3 ? 'where a sensor looks' : 'what the sensor sees', [[fan, styles.measurement]], 'fan', fans],
    ['what each camera sees', [[screen, styles.estimate]], 'view', views],
  ]
  return entries.filter(([, , , there = true]) => there).map(([words, marks, layer]) => {
    const parts = [sample(marks), words]
    if (!layer) return element('li', {}, element('span', {}, ...parts))
    shown[layer] = true
    const button = element('button', { type: 'button', ariaPressed: 'true', title: 'show or hide' }, ...parts)
    button.dataset.layer = layer
    button.onclick = () => {
      shown[layer] = !shown[layer]
      button.ariaPressed = String(shown[layer])
      changed()
    }
    return element('li', {}, button)
  })
}

function sample(marks) {
  const ratio = 2 * (window.devicePixelRatio || 1)
  const canvas = element('canvas', { width: W * ratio, height: H * ratio, ariaHidden: 'true' })
  const context = canvas.getContext('2d')
  context.scale(ratio, ratio)
  for (const [draw, style] of marks) {
    Object.assign(context, { strokeStyle: style.color, lineWidth: 1.8 })
    context.setLineDash({ '--': [6, 3], ':': [1.5, 3] }[style.linestyle] ?? [])
    context.beginPath()
    draw(context, style, [W / 2, H / 2])
    if (draw !== drawMarker) context.stroke()
  }
  return canvas
}

const name = context => (Object.assign(context, { font: '13px sans-serif', textAlign: 'center', textBaseline: 'middle', fillStyle: '#000' }), context.fillText('7', W / 2, H / 2))
const line = context => (context.moveTo(1, H / 2), context.lineTo(W - 1, H / 2))
const ellipse = context => context.ellipse(W / 2, H / 2, 14, 7, 0, 0, 7)
const ring = context => context.arc(W / 2, H / 2, 7.5, 0, 7)
const fan = context => (context.setLineDash([]), context.moveTo(5, H / 2), context.arc(5, H / 2, 24, -0.35, 0.35), context.closePath())
const screen = context => context.rect(4, 2, W - 8, H - 4)
