// The parts of the library OGL that the player in space uses: `make ogl` joins them in graphics/player/ogl.min.js.
export { Geometry, Mesh, Program, Renderer, Sphere, Transform } from 'ogl'
