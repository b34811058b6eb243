// Parts of the page around the picture: elements, tables, numbers.

export function element(tag, attributes = {}, ...children) {
  const node = Object.assign(document.createElement(tag), attributes)
  node.append(...children)
  return node
}

export const paragraph = (textContent, className = '') => element('p', { textContent, className })

export function table(head, rows) {
  const row = (cells, tag) => element('tr', {}, ...cells.map(textContent => element(tag, { textContent })))
  const body = rows.map(cells => row(cells, 'td'))
  return element('table', {}, element('thead', {}, row(head, 'th')), element('tbody', {}, ...body))
}

export const digits = (v, n = 3) => (Number.isFinite(v) ? Number(v.toPrecision(n)).toString().replace('-', '−') : 'unknown')
export const fixed = (v, n) => (Number.isFinite(v) ? v.toFixed(n).replace('-', '−') : 'unknown')
