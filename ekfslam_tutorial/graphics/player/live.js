// The player as a live view, for anywidget. Frames come one by one, each complete in itself, so that one that is lost
// does no harm; the whole log comes when the kernel has time for it.
import { Log } from './log.js'
import { Player } from './player.js'

const LIVE = new Map() // by the key of the model: what all its views share

class Live {
  constructor(model) {
    Object.assign(this, { model, hosts: new Map(), asked: false })
    this.begin()
    model.on('change:head', () => this.begin())
    model.on('msg:custom', message => this.receive(message))
  }

  // The first snapshot tells whether the world is flat, and which robots there are: only then can there be a picture.
  begin() {
    const head = this.model.get('head')
    this.log = head && new Log(head)
    this.asked = false
    this.hosts.forEach((_, host) => this.show(host))
  }

  show(host) {
    this.hosts.get(host)?.remove()
    this.hosts.set(host, this.log && new Player(host, this.log, this.model.get('options')))
    this.hosts.get(host)?.seek(Infinity)
  }

  hide(host) {
    this.hosts.get(host)?.remove()
    this.hosts.delete(host)
  }

  receive({ frames, total, whole }) {
    if (!this.log) return
    const players = [...this.hosts.values()], follows = players.map(player => player.at >= player.last)
    if (whole) Object.assign(this, { asked: false }).log.frames.length = 0
    frames.forEach(record => this.log.add(record))
    players.forEach((player, i) => player.grown(follows[i]))
    if (this.log.frames.length < total && !this.asked) {
      this.asked = true
      this.model.send('the whole log, please')
    }
  }
}

export default {
  initialize({ model }) {
    const key = model.get('key')
    LIVE.set(key, new Live(model))
    return () => LIVE.delete(key)
  },
  render({ model, el }) {
    const live = LIVE.get(model.get('key')), host = document.createElement('div')
    host.style.height = model.get('height')
    el.replaceChildren(host)
    live.show(host)
    return () => live.hide(host)
  },
}
