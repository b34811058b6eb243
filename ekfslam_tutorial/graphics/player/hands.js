// What the user can do with keys, mouse and fingers.
import { minus, norm } from './log.js'

const TURNS = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] } // pixels

// Let the player listen until `signal` is aborted.
export function listen(player, signal) {
  const on = (node, kind, act, more = {}) => node.addEventListener(kind, act, { signal, ...more })
  const fullScreen = () => (document.fullscreenElement ? document.exitFullscreen() : player.host.requestFullscreen())
  on(player.button, 'click', () => player.toggle())
  on(player.slider, 'input', () => player.step(player.slider.value - player.at))
  on(player.speed, 'change', () => player.setSpeed(player.speed.value))
  on(player.whole, 'click', () => player.wholePicture())
  on(player.full, 'click', fullScreen)
  on(player.grid, 'keydown', event => {
    if (!pressKey(player, event)) return
    event.preventDefault()
    event.stopPropagation()
  })
  const mouse = new Mouse(player)
  on(player.canvas, 'wheel', event => mouse.wheel(event), { passive: false })
  on(player.canvas, 'pointerdown', event => mouse.press(event))
  on(player.canvas, 'pointermove', event => mouse.move(event))
  on(player.canvas, 'pointerup', event => mouse.release(event))
  on(player.canvas, 'pointercancel', event => mouse.release(event))
  on(player.canvas, 'pointerleave', () => player.hover(null))
}

// Whether the key meant something.
function pressKey(player, { key, target, shiftKey, ctrlKey, altKey, metaKey }) {
  if (ctrlKey || altKey || metaKey || target === player.speed) return false
  const turn = TURNS[key], presses = target.matches('button, summary') && target !== player.button
  if (shiftKey && turn) player.turn(...turn)
  else if (key === ' ' && !presses) player.toggle()
  else if (key === 'ArrowLeft') player.step(-1)
  else if (key === 'ArrowRight') player.step(1)
  else if (key === 'Home') player.step(-Infinity)
  else if (key === 'End') player.step(Infinity)
  else if (key === '+' || key === '=') player.faster(1)
  else if (key === '-') player.faster(-1)
  else if (key === 'PageUp') player.zoom(1.25)
  else if (key === 'PageDown') player.zoom(0.8)
  else if (key === '0') player.wholePicture()
  else if (key === 'Escape' && player.pinned !== null) player.choose(null)
  else if (turn && target === player.canvas) player.cycle(key === 'ArrowUp' ? -1 : 1)
  else return false
  return true
}

class Mouse {
  constructor(player) {
    Object.assign(this, { player, pointers: new Map(), travelled: 0 })
  }

  spot({ clientX, clientY }) {
    const box = this.player.canvas.getBoundingClientRect()
    return [clientX - box.left, clientY - box.top]
  }

  // The wheel scrolls the page until the picture has been clicked; a page of its own has nothing to scroll.
  wheel(event) {
    const { player } = this
    if (!(player.options.page || event.ctrlKey || player.root.activeElement === player.canvas)) return
    event.preventDefault()
    player.zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)), ...this.spot(event))
  }

  press(event) {
    this.player.canvas.focus()
    this.player.canvas.setPointerCapture(event.pointerId)
    this.pointers.set(event.pointerId, this.spot(event))
    this.travelled = 0
  }

  move(event) {
    const { player } = this, now = this.spot(event), before = this.pointers.get(event.pointerId)
    if (!before) return player.hover(player.scene.find(...now))
    const [dx, dy] = minus(now, before), other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1]
    this.pointers.set(event.pointerId, now)
    this.travelled += norm([dx, dy])
    if (other) player.zoom(norm(minus(now, other)) / Math.max(norm(minus(before, other)), 1))
    else if (this.travelled >= CLICK) player.turn(dx, dy, event.shiftKey || event.buttons & 6)
  }

  release(event) {
    const click = this.travelled < CLICK && event.type === 'pointerup'
    if (click) this.player.choose(this.player.scene.find(...this.spot(event), 22))
    this.pointers.delete(event.pointerId)
  }
}

const CLICK = 4 // pixels; a mouse that moves less has not been dragged
