// The replay player: plays a state log on a canvas, without a library and without a request to anywhere.
//   mount(host, data, options)        data as StateLog.to_dict() gives it; options: {styles, bodies, sigma, page}
import { element, paragraph } from './element.js'
import { makeLegend } from './legend.js'
import { Log, minus, norm } from './log.js'
import { readout } from './readout.js'
import { Scene, drawMarker } from './scene.js'

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
    Object.assign(this, { host, log, options, at: 0, fps: 10, playing: false, pinned: null, hovered: null })
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) this.fps = 2
    this.stop = new AbortController() // removes all listeners at once
    host.setAttribute('data-lm-suppress-shortcuts', 'true') // JupyterLab's own keys: not in here
    this.root = host.shadowRoot ?? host.attachShadow({ mode: 'open' })
    this.build()
    this.scene = new Scene(this.canvas, log, options)
    this.legend.append(...makeLegend(options, log, this.scene.shown, () => this.paint()))
    this.observer = new ResizeObserver(() => this.resize())
    this.observer.observe(this.stage)
    this.listen()
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
    this.stage = element('div', { className: 'stage' }, this.canvas)
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
    const grid = element('div', { className: 'grid' }, this.status, this.stage, this.controls, this.readout, this.legend)
    this.root.replaceChildren(element('style', { textContent: CSS }), element('div', { className: 'player' }, grid))
    this.fps = this.speed.value = this.fps
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

  faster(n) {
    const i = SPEEDS.indexOf(this.fps) + n
    this.fps = this.speed.value = SPEEDS[Math.min(Math.max(i, 0), SPEEDS.length - 1)]
    this.fps = Number(this.fps)
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
  }

  say() {
    const frame = this.log.frames[this.at], { title } = this.log.head
    const words = [element('b', { textContent: title })]
    if (frame) {
      const used = frame.obs.filter(o => o.used).length, rejected = frame.obs.length - used
      const parts = [`frame ${frame.k}`, `t = ${frame.t.toFixed(1)} s`, `${frame.lmks.size} landmarks`, `${used} corrected`]
      if (rejected) parts.push(`${rejected} rejected`)
      if (frame.missed.length) parts.push(`${frame.missed.length} not found`)
      if (frame.fresh.length) parts.push(`${frame.fresh.length} new`)
      if (frame.lost.length) parts.push(`${frame.lost.length} deleted`)
      const notes = { refused: 'not started, the map is full', recovery: 'gate opened: the robot was lost' }
      for (const [what, lmk] of frame.notes) parts.push(lmk < 0 ? notes[what] : `${lmk}: ${notes[what]}`)
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
    const i = keys.indexOf(this.pinned)
    this.choose(keys[i < 0 ? (n > 0 ? 0 : keys.length - 1) : (i + n + keys.length) % keys.length])
  }

  read() {
    const frame = this.log.frames[this.at], key = this.chosen, { truth } = this.scene.shown
    const parts = frame && key !== null ? readout(this.log, frame, key, truth) : [paragraph(HINT, 'hint')]
    const box = element('div', {}, ...parts)
    if (box.textContent !== this.readout.textContent) this.readout.replaceChildren(box)
  }

  // ------------------------------------------------------------------------------------------------------- listening

  listen() {
    const on = (node, kind, act, options = {}) => node.addEventListener(kind, act, { signal: this.stop.signal, ...options })
    on(this.button, 'click', () => this.toggle())
    on(this.slider, 'input', () => (this.pause(), this.seek(Number(this.slider.value))))
    on(this.speed, 'change', () => (this.fps = Number(this.speed.value)))
    on(this.whole, 'click', () => this.wholePicture())
    on(this.full, 'click', () => (document.fullscreenElement ? document.exitFullscreen() : this.host.requestFullscreen()))
    on(this.root.firstElementChild.nextElementSibling, 'keydown', event => this.key(event))
    on(this.canvas, 'wheel', event => this.wheel(event), { passive: false })
    on(this.canvas, 'pointerdown', event => this.press(event))
    on(this.canvas, 'pointermove', event => this.drag(event))
    for (const kind of ['pointerup', 'pointercancel']) on(this.canvas, kind, event => this.release(event))
    on(this.canvas, 'pointerleave', () => this.hover(null))
    this.pointers = new Map()
  }

  wholePicture() {
    this.scene.fit()
    this.paint()
  }

  key(event) {
    const { key, shiftKey, target, ctrlKey, altKey, metaKey } = event
    if (ctrlKey || altKey || metaKey || target === this.speed) return
    const turn = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] }[key]
    const picture = target === this.canvas
    if (shiftKey && turn) this.swing(...turn)
    else if (key === ' ' && (target === this.button || !target.matches('button, summary'))) this.toggle()
    else if (key === 'ArrowLeft' || key === 'ArrowRight') this.step(key === 'ArrowLeft' ? -1 : 1)
    else if (key === 'Home') this.step(-Infinity)
    else if (key === 'End') this.step(Infinity)
    else if (key === '+' || key === '=') this.faster(1)
    else if (key === '-') this.faster(-1)
    else if (key === 'PageUp' || key === 'PageDown') this.scene.camera.zoom(key === 'PageUp' ? 1.25 : 0.8), this.paint()
    else if (key === '0') this.wholePicture()
    else if (key === 'Escape' && this.pinned !== null) this.choose(null)
    else if (picture && turn) this.cycle(key === 'ArrowUp' ? -1 : 1)
    else return
    event.preventDefault()
    event.stopPropagation()
  }

  swing(dx, dy) {
    const { camera } = this.scene
    if (this.log.d === 2) camera.move(-dx, -dy)
    else camera.orbit(dx, dy)
    this.paint()
  }

  // The wheel scrolls the page until the picture has been clicked; a page of its own has nothing to scroll.
  wheel(event) {
    if (!(this.options.page || event.ctrlKey || this.root.activeElement === this.canvas)) return
    event.preventDefault()
    const [x, y] = this.spot(event)
    this.scene.camera.zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)), x, y)
    this.paint()
  }

  spot({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect()
    return [clientX - box.left, clientY - box.top]
  }

  press(event) {
    this.canvas.focus()
    this.canvas.setPointerCapture(event.pointerId)
    this.pointers.set(event.pointerId, this.spot(event))
    this.travelled = 0
  }

  drag(event) {
    const now = this.spot(event), before = this.pointers.get(event.pointerId), { camera } = this.scene
    if (!before) return this.hover(this.scene.find(...now))
    const [dx, dy] = minus(now, before)
    this.pointers.set(event.pointerId, now)
    this.travelled += norm([dx, dy])
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1]
    if (other) camera.zoom(norm(minus(now, other)) / Math.max(norm(minus(before, other)), 1))
    else if (this.travelled < 4) return
    else if (this.log.d === 2 || event.shiftKey || event.buttons & 6) camera.move(dx, dy)
    else camera.orbit(dx, dy)
    this.paint()
  }

  release(event) {
    if (this.travelled < 4 && event.type === 'pointerup') this.choose(this.scene.find(...this.spot(event), 22))
    this.pointers.delete(event.pointerId)
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
  }
}
