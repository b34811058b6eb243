// What WebGL does with a shape that stands in many places, and with a line that is some pixels wide.

export const SHAPES = {
  vertex: `#version 300 es
    in vec3 position, normal, ax, ay, az, centre;
    in vec4 color;
    uniform mat4 view, projection;
    out vec3 n, v;
    out vec4 c;
    void main() {
      vec4 eye = view * vec4(mat3(ax, ay, az) * position + centre, 1.0);
      n = mat3(view) * (ax * normal.x / dot(ax, ax) + ay * normal.y / dot(ay, ay) + az * normal.z / dot(az, az));
      v = eye.xyz;
      c = color;
      gl_Position = projection * eye;
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 n, v;
    in vec4 c;
    out vec4 seen;
    void main() {
      vec3 u = normalize(n);
      float front = abs(dot(u, normalize(v))), light = 0.62 + 0.38 * abs(dot(u, normalize(vec3(0.3, 0.7, 0.6))));
      float rim = c.a < 1.0 ? (1.0 - front) * (1.0 - front) : 0.0; // of what one can see through, the border is seen best
      seen = vec4(c.rgb * light, min(1.0, c.a * (1.0 + 2.0 * rim)));
    }`,
}

// A line is a strip between two points: each corner is moved aside by half a width, in pixels.
export const LINES = {
  vertex: `#version 300 es
    in vec2 position;
    in vec3 start, end;
    in vec4 color;
    in vec3 look; // width in pixels, metres of a dash and its gap, metres of the line before
    uniform mat4 view, projection;
    uniform vec2 size;
    out vec4 c;
    out vec2 dash, side;
    void main() {
      vec4 a = view * vec4(start, 1.0), b = view * vec4(end, 1.0);
      float near = -0.01;
      if (a.z > near) a = mix(a, b, (near - a.z) / (b.z - a.z));
      if (b.z > near) b = mix(b, a, (near - b.z) / (a.z - b.z));
      a = projection * a, b = projection * b;
      vec2 along = (b.xy / b.w - a.xy / a.w) * size;
      vec2 aside = vec2(-along.y, along.x) / max(length(along), 1e-6);
      gl_Position = position.x < 0.5 ? a : b;
      float half_width = 0.5 * look.x + 0.5; // with half a pixel that fades
      gl_Position.xy += aside * position.y * 2.0 * half_width / size * gl_Position.w;
      side = vec2(position.y * half_width, half_width);
      gl_Position.z -= 1e-4 * gl_Position.w; // in front of the surface that it lies on
      c = color;
      dash = vec2(look.z + position.x * length(end - start), look.y);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec4 c;
    in vec2 dash, side;
    out vec4 seen;
    void main() {
      if (dash.y > 0.0 && fract(dash.x / dash.y) > 0.6) discard;
      seen = vec4(c.rgb, c.a * clamp(side.y - abs(side.x), 0.0, 1.0));
    }`,
}
