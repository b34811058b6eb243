// The stage in space: shapes and lines, given anew for each frame, drawn by WebGL through the library OGL.
import { cross, minus } from './log.js'
import { LINES, SHAPES } from './shaders.js'

const STRIP = [[0, -1], [1, -1], [1, 1], [0, -1], [1, 1], [0, 1]] // of the two triangles of a line

export class Stage {
  constructor() {
    const canvas = document.createElement('canvas'), kind = { alpha: false, premultipliedAlpha: false }
    if (!canvas.getContext('webgl2', { ...kind, antialias: hasGraphicsCard() })) return
    this.renderer = new OGL.Renderer({ canvas, ...kind }) // takes the context that the canvas has
    this.gl = this.renderer.gl
    this.gl.clearColor(1, 1, 1, 1)
    this.root = new OGL.Transform()
    this.seen = { view: { value: [] }, projection: { value: [] }, size: { value: [1, 1] } }
    const program = (code, more) => new OGL.Program(this.gl, { ...code, uniforms: this.seen, cullFace: null, ...more })
    this.programs = {
      solid: program(SHAPES),
      glass: program(SHAPES, { transparent: true, depthWrite: false, cullFace: this.gl.BACK }),
      line: program(LINES, { transparent: true }),
    }
    const { position, normal, index } = new OGL.Sphere(this.gl, { radius: 1, widthSegments: 18 }).attributes
    const plain = ({ data }, size) => ({ data, size })
    this.forms = { ball: { position: plain(position, 3), normal: plain(normal, 3), index: plain(index, 1) } }
  }

  get canvas() {
    return this.gl?.canvas
  }

  resize(width, height, ratio) {
    if (!this.gl) return
    this.renderer.dpr = ratio
    this.renderer.setSize(width, height)
  }

  // Give a shape with flat faces a name.
  form(name, faces) {
    const position = [], normal = []
    for (const face of faces) {
      const [p, q, r] = face, n = cross(minus(q, p), minus(r, p))
      for (let i = 2; i < face.length; i++) {
        position.push(...p, ...face[i - 1], ...face[i])
        normal.push(...n, ...n, ...n)
      }
    }
    if (this.gl) this.forms[name] = { position: { size: 3, data: new Float32Array(position) }, normal: { size: 3, data: new Float32Array(normal) } }
  }

  clear() {
    for (const mesh of [...this.root?.children ?? []]) {
      mesh.setParent(null)
      mesh.geometry.remove()
    }
  }

  // Shapes of one form: [{axes: three columns, centre, color, alpha}].
  shapes(form, rows, order) {
    const glass = rows.filter(row => row.alpha < 1), solid = rows.filter(row => !(row.alpha < 1))
    for (const [program, some] of [['solid', solid], ['glass', glass]]) {
      const columns = i => ({ size: 3, data: some.map(row => row.axes[i]) })
      this.add(program, this.forms?.[form], order, some.length, {
        ax: columns(0), ay: columns(1), az: columns(2),
        centre: { size: 3, data: some.map(row => row.centre) },
        color: { size: 4, data: some.map(row => [...rgb(row.color), row.alpha ?? 1]) },
      })
    }
  }

  // Lines [{from, to, color, width, dash, before, alpha}]. Each is written out, corner by corner: a computer without a
  // graphics card takes longer for each instance than for these few numbers.
  lines(rows, order) {
    const field = (size, of) => ({ size, data: rows.flatMap(row => Array(STRIP.length).fill(of(row))) })
    this.add('line', {}, order, rows.length, {
      position: { size: 2, data: rows.map(() => STRIP).flat() },
      start: field(3, row => row.from),
      end: field(3, row => row.to),
      color: field(4, row => [...rgb(row.color), row.alpha ?? 1]),
      look: field(3, row => [row.width * (window.devicePixelRatio || 1), row.dash ?? 0, row.before ?? 0]),
    }, {})
  }

  add(program, form, renderOrder, n, fields, how = { instanced: 1 }) {
    if (!this.gl || !n) return
    const attributes = Object.fromEntries(Object.entries(form).map(([name, { size, data }]) => [name, { size, data }]))
    for (const [name, { size, data }] of Object.entries(fields)) {
      attributes[name] = { size, data: new Float32Array(data.flat()), ...how }
    }
    const mesh = new OGL.Mesh(this.gl, { geometry: new OGL.Geometry(this.gl, attributes), program: this.programs[program], frustumCulled: false, renderOrder })
    mesh.setParent(this.root)
  }

  // Draw everything as an eye sees it, into [w, h] pixels at the lower left of the canvas.
  draw({ view, projection }, [w, h]) {
    this.seen.view.value = view
    this.seen.projection.value = projection
    const { renderer } = this, { width, height } = renderer
    this.seen.size.value = [w * renderer.dpr, h * renderer.dpr]
    Object.assign(renderer, { width: w, height: h })
    renderer.render({ scene: this.root })
    Object.assign(renderer, { width, height })
  }

  remove() {
    this.gl?.getExtension('WEBGL_lose_context')?.loseContext()
  }
}

// A computer without a graphics card would spend most of its time on smooth borders.
function hasGraphicsCard() {
  const gl = document.createElement('canvas').getContext('webgl2'), told = gl?.getExtension('WEBGL_debug_renderer_info')
  const name = gl?.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER) ?? ''
  gl?.getExtension('WEBGL_lose_context')?.loseContext()
  return !/swiftshader|llvmpipe|software|basic render/i.test(name)
}

const rgb = hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255)
