// The replay player: plays a state log, in the plane or in space, without a request to anywhere.
//   mount(host, data, options)  data as StateLog.to_dict() gives it; options: {styles, robots, bodies, sigma, page}
import { element, paragraph } from './element.js'
import { makeLegend } from './legend.js'
import { Log } from './log.js'
import { readout } from './readout.js'
import { listen } from './hands.js'
import { drawMarker } from './pen.js'
import { Scene } from './scene.js'
import { Space } from './space.js'

const SPEEDS = [1, 2, 5, 10, 20, 40] // frames per second
const KEYS = [
  ['Space', 'play, pause'],
  ['← →', 'one frame back, on'],
  ['Home End', 'first, last frame'],
  ['+ −', 'faster, slower'],
  ['↑ ↓', 'read a landmark or robot (in the picture), Esc: none'],
  ['Shift + arrows', 'turn or move the picture'],
  ['PgUp PgDn', 'closer, further; also the wheel, after a click'],
  ['0', 'whole picture'],
]
const HINT = 'Point at a landmark, or press ↑ ↓ in the picture: its covariance and innovation are shown here.'
const ICONS = { play: 'M3 1.5v13l11-6.5z', pause: 'M3 1.5h3.6v13H3zM9.4 1.5H13v13H9.4z' }

export function mount(host, data, options) {
  return new Player(host, new Log(data), options)
}

export class Player {
  constructor(host, log, options) {
    Object.assign(this, { host, log, options, at: 0, playing: false, pinned: null, hovered: null })
    this.stop = new AbortController() // removes all listeners at once
    host.setAttribute('data-lm-suppress-shortcuts', 'true') // JupyterLab's own keys: not in here
    this.root = host.shadowRoot ?? host.attachShadow({ mode: 'open' })
    this.build()
    this.scene = log.d === 2 ? new Scene(this.canvas, log, options) : new Space(this.canvas, log, options)
    this.legend.append(...makeLegend(options, log, this.scene.shown, () => this.resize()))
    this.observer = new ResizeObserver(() => this.resize())
    this.observer.observe(this.stage)
    listen(this, this.stop.signal)
    this.grown()
    this.resize()
  }

  // ------------------------------------------------------------------------------------------------------- elements

  build() {
    const { head } = this.log
    this.status = element('div', { className: 'status', role: 'status' })
    this.canvas = element('canvas', { tabIndex: 0 })
    this.canvas.setAttribute('role', 'application')
    this.canvas.setAttribute('aria-label', `Map${head.title ? ` of ${head.title}` : ''}. Up and down arrows read landmarks.`)
    this.image = element('figure', { hidden: true }, element('img', { alt: '' }), element('figcaption'))
    this.stage = element('div', { className: 'stage' }, this.canvas, this.image)
    this.button = element('button', { className: 'play', type: 'button' })
    this.slider = element('input', { type: 'range', min: 0, step: 1, value: 0, ariaLabel: 'Frame' })
    this.events = element('canvas', { ariaHidden: 'true' })
    const speeds = SPEEDS.map(n => element('option', { value: n, textContent: `${n} frames/s` }))
    this.speed = element('select', { ariaLabel: 'Speed', title: 'Speed' }, ...speeds)
    this.whole = element('button', { type: 'button', textContent: 'Whole picture' })
    this.full = element('button', { type: 'button', textContent: 'Full screen', hidden: !document.fullscreenEnabled })
    const keys = KEYS.map(([key, what]) => element('p', {}, element('kbd', { textContent: key }), ` ${what}`))
    this.legend = element('ul', { className: 'legend', ariaLabel: 'Legend; buttons show and hide' })
    this.readout = element('div', { className: 'readout' })
    this.controls = element(
      'div', { className: 'controls' },
      this.button, element('div', { className: 'track' }, this.events, this.slider), this.speed, this.whole, this.full,
      element('details', {}, element('summary', { textContent: 'Keys' }), element('div', {}, ...keys)),
    )
    this.grid = element('div', { className: 'grid' }, this.status, this.stage, this.controls, this.readout, this.legend)
    this.root.replaceChildren(element('style', { textContent: CSS }), element('div', { className: 'player' }, this.grid))
    this.setSpeed(matchMedia('(prefers-reduced-motion: reduce)').matches ? 2 : 10)
    this.setButton()
  }

  // --------------------------------------------------------------------------------------------------------- playing

  get last() {
    return Math.max(this.log.frames.length - 1, 0)
  }

  seek(i) {
    this.at = Math.min(Math.max(Math.round(i), 0), this.last)
    this.slider.value = this.at
    this.paint()
  }

  step(n) {
    this.pause()
    this.seek(this.at + n)
  }

  play() {
    if (this.playing || this.last === 0) return
    if (this.at === this.last) this.seek(0)
    this.playing = true
    this.setButton()
    let due = performance.now() + 1000 / this.fps
    const tick = now => {
      if (!this.playing) return
      const n = now < due ? 0 : 1 + Math.floor(((now - due) * this.fps) / 1000) // late: frames are left out, not time
      due += (n * 1000) / this.fps
      if (n) this.seek(this.at + n)
      if (this.at === this.last) this.pause()
      else this.timer = requestAnimationFrame(tick)
    }
    this.timer = requestAnimationFrame(tick)
  }

  pause() {
    if (!this.playing) return
    this.playing = false
    this.setButton()
    this.paint()
  }

  toggle() {
    if (this.playing) this.pause()
    else this.play()
  }

  setSpeed(fps) {
    this.fps = Number(fps)
    this.speed.value = fps
  }

  faster(n) {
    const i = SPEEDS.indexOf(this.fps) + n
    this.setSpeed(SPEEDS[Math.min(Math.max(i, 0), SPEEDS.length - 1)])
  }

  setButton() {
    const name = this.playing ? 'pause' : 'play'
    this.button.ariaLabel = this.button.title = this.playing ? 'Pause' : 'Play'
    this.button.innerHTML = `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`
    for (const node of [this.status, this.readout]) node.ariaLive = this.playing ? 'off' : 'polite'
  }

  // The log has got more frames. A viewer at its end stays at its end.
  grown(follow = false) {
    this.slider.max = this.last
    this.slider.disabled = this.last === 0
    if (this.scene.camera.size[0] > 100 && !this.scene.camera.touched) this.scene.fit(false)
    if (follow) this.seek(this.last)
    else this.paint()
  }

  // --------------------------------------------------------------------------------------------------------- drawing

  resize() {
    const { clientWidth: w, clientHeight: h } = this.stage
    if (!w || !h) return
    this.scene.resize(w, h, parseFloat(getComputedStyle(this.status).fontSize))
    if (!this.scene.camera.touched) this.scene.fit()
    this.draw()
  }

  paint() {
    this.pending ??= requestAnimationFrame(() => this.draw())
  }

  draw() {
    this.pending = null
    if (this.scene.ratio !== (window.devicePixelRatio || 1) && this.scene.ratio) return this.resize()
    if (!this.scene.ratio) return
    this.scene.draw(this.at, this.chosen)
    this.drawn = (this.drawn ?? 0) + 1
    this.say()
    this.drawEvents()
    this.read()
    this.see(this.log.frames[this.at]?.image)
  }

  // What the camera saw, in a corner: there is an image for every so many frames of the run.
  see(image) {
    if (this.seen === image) return
    this.seen = image
    this.image.hidden = !image
    if (!image) return
    const [picture, caption] = this.image.children, n = this.log.head.images
    Object.assign(picture, { src: image.src, alt: `Image of frame ${image.k}` })
    caption.textContent = `image of frame ${image.k}${n > 1 ? `; one for every ${n} frames` : ''}`
  }

  say() {
    const frame = this.log.frames[this.at], { title } = this.log.head
    const words = [element('b', { textContent: title })]
    if (frame) {
      const used = frame.obs.filter(o => o.used).length, rejected = frame.obs.length - used
      const parts = [`frame ${frame.k}`, `t = ${frame.t.toFixed(1)} s`, `${frame.lmks.size + frame.lines.size} landmarks`, `${used} corrected`]
      if (rejected) parts.push(`${rejected} rejected`)
      if (frame.missed.length) parts.push(`${frame.missed.length} not found`)
      if (frame.fresh.length) parts.push(`${frame.fresh.length} new`)
      if (frame.lost.length) parts.push(`${frame.lost.length} deleted`)
      const full = frame.notes.filter(([what]) => what === 'refused').length
      if (full) parts.push(`${full} not started: the map is full`)
      if (full < frame.notes.length) parts.push('gate opened: the robot was lost')
      this.words = parts.join(', ')
    } else {
      this.words = 'waiting for the first frame'
    }
    if (this.status.textContent !== title + this.words) this.status.replaceChildren(...words, this.words)
    this.slider.setAttribute('aria-valuetext', this.words)
  }

  // Over the slider: how many measurements each frame used, and where something special happened.
  drawEvents() {
    const { frames } = this.log, w = this.events.clientWidth, ratio = window.devicePixelRatio || 1
    if (!w || (this.eventsFor === `${frames.length} ${w} ${ratio}`)) return
    this.eventsFor = `${frames.length} ${w} ${ratio}`
    Object.assign(this.events, { width: w * ratio, height: 22 * ratio })
    const context = this.events.getContext('2d'), { styles } = this.options
    context.scale(ratio, ratio)
    const most = Math.max(1, ...frames.map(f => f.obs.length)), x = i => 8 + (i / Math.max(this.last, 1)) * (w - 16)
    const bar = Math.max(1, Math.min(5, (w - 16) / frames.length - 1))
    frames.forEach((frame, i) => {
      const used = frame.obs.filter(o => o.used).length
      context.fillStyle = '#BFDCEF'
      context.fillRect(x(i) - bar / 2, 22 - (12 * used) / most, bar, (12 * used) / most)
      if (frame.lost.length) drawMarker(context, styles.deleted, [x(i), 5], 0.7)
      else if (used < frame.obs.length) drawMarker(context, styles.rejected, [x(i), 5], 0.7)
    })
  }

  // --------------------------------------------------------------------------------------------------------- reading

  get chosen() {
    return this.hovered ?? this.pinned
  }

  choose(key) {
    this.pinned = key
    this.paint()
  }

  // The next landmark or robot, in the order of their ids, robots first.
  cycle(n) {
    const keys = this.scene.items.map(item => item.key)
    keys.sort((a, b) => (typeof a === typeof b ? (a > b ? 1 : -1) : typeof a === 'string' ? -1 : 1))
    if (!keys.length) return
    this.hovered = null
    const i = keys.indexOf(this.pinned)
    this.choose(keys[i < 0 ? (n > 0 ? 0 : keys.length - 1) : (i + n + keys.length) % keys.length])
  }

  read() {
    const frame = this.log.frames[this.at], key = this.chosen, { truth } = this.scene.shown
    const parts = frame && key !== null ? readout(this.log, frame, key, truth) : [paragraph(HINT, 'hint')]
    const box = element('div', {}, ...parts)
    if (box.textContent !== this.readout.textContent) this.readout.replaceChildren(box)
  }

  wholePicture() {
    this.scene.fit()
    this.paint()
  }

  zoom(factor, ...at) {
    this.scene.camera.zoom(factor, ...at)
    this.paint()
  }

  // Drag the picture so many pixels: it turns in space, and is moved in the plane or if told so.
  turn(dx, dy, move = this.log.d === 2) {
    if (move || this.log.d === 2) this.scene.camera.move(dx, dy)
    else this.scene.camera.orbit(dx, dy)
    this.paint()
  }

  hover(key) {
    if (key === this.hovered) return
    this.hovered = key
    this.paint()
  }

  remove() {
    this.playing = false
    this.stop.abort()
    this.observer.disconnect()
    this.scene.stage?.remove()
  }
}
