// Small figures on canvases, for the pictures that follow the pointer: a fifth of the work of a Bokeh figure, since
// there is no layout to compute.
const EDGES = { left: 62, right: 16, top: 8, bottom: 44 }, SECOND = { ...EDGES, right: 62, top: 44 }
const FONT = 'system-ui, "Segoe UI", Roboto, Arial, sans-serif'

function ticks(low, high, most) {
  const rough = (high - low) / most, unit = 10 ** Math.floor(Math.log10(rough))
  const step = [1, 2, 5, 10].find((size) => size * unit >= rough) * unit
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), found = []
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    found.push([i * step, (i * step).toFixed(places).replace("-", "−")])
  }
  return found
}

// A figure in a box of the page. A picture has the ends and labels of its axes x and y, and its parts: each one is
// a band, a line, a disc, marks, texts or a vertical line in data coordinates, with a colour. `square`: equal scales.
// `second`: for each axis, the label and the scale of a second axis on the opposite side.
function sketch(box) {
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d")
  let picture = null, scale = null, EDGE = EDGES
  box.append(canvas)
  new ResizeObserver(() => { if (picture) draw(picture) }).observe(box)

  function fit(wide, high) {
    let { x: [x0, x1], y: [y0, y1] } = picture
    const across = wide - EDGE.left - EDGE.right, up = high - EDGE.top - EDGE.bottom
    if (picture.square) {
      const part = Math.max((x1 - x0) / across, (y1 - y0) / up), half = 0.5 * part
      const x = 0.5 * (x0 + x1), y = 0.5 * (y0 + y1)
      ;[x0, x1, y0, y1] = [x - half * across, x + half * across, y - half * up, y + half * up]
    }
    const right = across / (x1 - x0), upwards = up / (y1 - y0)
    return { x0, x1, y0, y1, across, up, right,
      x: (x) => EDGE.left + (x - x0) * right, y: (y) => EDGE.top + up - (y - y0) * upwards,
      place: (x, y) => [x0 + (x - EDGE.left) / right, y0 + (EDGE.top + up - y) / upwards] }
  }
  function path(xs, ys) {
    for (let i = 0; i < xs.length; i++) pen.lineTo(scale.x(xs[i]), scale.y(ys[i]))
  }
  function axes() {
    const { x0, x1, y0, y1, across, up } = scale, bottom = EDGE.top + up
    const beside = ticks(x0, x1, across / 45), upward = ticks(y0, y1, up / 40)
    pen.lineWidth = 1
    for (const [shade, begin, end] of [["#EBEBEB", 0, 1], ["#444444", -6, 0]]) {
      pen.strokeStyle = shade
      pen.beginPath()
      for (const [x] of beside) {
        const at = Math.round(scale.x(x)) + 0.5
        pen.moveTo(at, bottom - (begin || 0))
        pen.lineTo(at, bottom - end * up)
      }
      for (const [y] of upward) {
        const at = Math.round(scale.y(y)) + 0.5
        pen.moveTo(EDGE.left + begin, at)
        pen.lineTo(EDGE.left + end * across, at)
      }
      pen.stroke()
    }
    pen.strokeRect(EDGE.left + 0.5, EDGE.top, 0, up)
    pen.strokeRect(EDGE.left, bottom + 0.5, across, 0)
    pen.fillStyle = "#222222"
    pen.font = `12px ${FONT}`
    Object.assign(pen, { textAlign: "center", textBaseline: "top" })
    for (const [x, text] of beside) pen.fillText(text, scale.x(x), bottom + 9)
    Object.assign(pen, { textAlign: "right", textBaseline: "middle" })
    for (const [y, text] of upward) pen.fillText(text, EDGE.left - 9, scale.y(y))
    pen.font = `13px ${FONT}`
    Object.assign(pen, { textAlign: "center", textBaseline: "bottom" })
    pen.fillText(picture.labels[0], EDGE.left + 0.5 * across, bottom + EDGE.bottom - 1)
    pen.save()
    pen.translate(3, EDGE.top + 0.5 * up)
    pen.rotate(-0.5 * Math.PI)
    pen.textBaseline = "top"
    pen.fillText(picture.labels[1], 0, 0)
    pen.restore()
    if (picture.second) opposite(picture.second)
  }
  // the axes at the top and at the right
  function opposite([[above, times], [right, upTimes]]) {
    const { x0, x1, y0, y1, across, up } = scale, end = EDGE.left + across
    const beside = ticks(x0 * times, x1 * times, across / 38), upward = ticks(y0 * upTimes, y1 * upTimes, up / 30)
    pen.strokeStyle = "#444444"
    pen.strokeRect(end + 0.5, EDGE.top, 0, up)
    pen.strokeRect(EDGE.left, EDGE.top + 0.5, across, 0)
    pen.beginPath()
    for (const [x] of beside) {
      const at = Math.round(scale.x(x / times)) + 0.5
      pen.moveTo(at, EDGE.top)
      pen.lineTo(at, EDGE.top - 6)
    }
    for (const [y] of upward) {
      const at = Math.round(scale.y(y / upTimes)) + 0.5
      pen.moveTo(end, at)
      pen.lineTo(end + 6, at)
    }
    pen.stroke()
    pen.font = `12px ${FONT}`
    Object.assign(pen, { textAlign: "center", textBaseline: "bottom" })
    for (const [x, text] of beside) pen.fillText(text, scale.x(x / times), EDGE.top - 8)
    Object.assign(pen, { textAlign: "left", textBaseline: "middle" })
    for (const [y, text] of upward) pen.fillText(text, end + 9, scale.y(y / upTimes))
    pen.font = `13px ${FONT}`
    Object.assign(pen, { textAlign: "center", textBaseline: "top" })
    pen.fillText(above, EDGE.left + 0.5 * across, 1)
    pen.save()
    pen.translate(end + EDGE.right - 3, EDGE.top + 0.5 * up)
    pen.rotate(-0.5 * Math.PI)
    pen.textBaseline = "bottom"
    pen.fillText(right, 0, 0)
    pen.restore()
  }
  function mark(kind, x, y, size) {
    const turn = kind === "inverted_triangle" ? -1 : 1
    pen.beginPath()
    if (kind === "circle") pen.arc(x, y, size, 0, 2 * Math.PI)
    else if (kind === "x") {
      for (const side of [-1, 1]) {
        pen.moveTo(x - size, y - side * size)
        pen.lineTo(x + size, y + side * size)
      }
    } else for (const corner of [0, 1, 2]) {
      const angle = (corner / 1.5 - 0.5 * turn) * Math.PI
      pen.lineTo(x + 1.2 * size * Math.cos(angle), y + 1.2 * size * Math.sin(angle))
    }
    pen.closePath()
    pen.fill()
    pen.stroke()
  }
  const parts = {
    band: ([x, low, high]) => {
      pen.beginPath()
      path(x, low)
      path([...x].reverse(), [...high].reverse())
      pen.fill()
    },
    line: ([x, y]) => {
      pen.beginPath()
      path(x, y)
      pen.stroke()
    },
    upright: (x) => {
      pen.beginPath()
      path([x, x], [scale.y0, scale.y1])
      pen.stroke()
    },
    disc: (radius) => {
      pen.beginPath()
      pen.arc(scale.x(0), scale.y(0), radius * scale.right, 0, 2 * Math.PI)
      pen.fill()
      Object.assign(pen, { globalAlpha: 1, strokeStyle: "#222222" })
      pen.stroke()
    },
    marks: ([x, y, kinds], { size, border }) => {
      if (border) pen.strokeStyle = border
      for (let i = 0; i < x.length; i++) mark(kinds[i], scale.x(x[i]), scale.y(y[i]), size)
    },
    texts: ([x, y, texts]) => {
      pen.textBaseline = "bottom"
      texts.forEach((text, i) => {
        pen.textAlign = x[i] > 0 ? "right" : "left"
        pen.fillText(text, scale.x(x[i]), scale.y(y[i]) - 8)
      })
    },
  }
  function draw(next) {
    const { clientWidth: wide, clientHeight: high } = box, dense = devicePixelRatio
    picture = next
    if (canvas.width !== Math.round(wide * dense) || canvas.height !== Math.round(high * dense)) {
      canvas.width = Math.round(wide * dense)
      canvas.height = Math.round(high * dense)
    }
    pen.setTransform(dense, 0, 0, dense, 0, 0)
    pen.clearRect(0, 0, wide, high)
    EDGE = picture.second ? SECOND : EDGES
    scale = fit(wide, high)
    if (scale.across <= 0 || scale.up <= 0) return
    axes()
    pen.save()
    pen.font = `12px ${FONT}`
    pen.beginPath()
    // a mark on the edge is not clipped
    pen.rect(EDGE.left - 5, EDGE.top - 5, scale.across + 10, scale.up + 10)
    pen.clip()
    for (const part of picture.parts) {
      Object.assign(pen, { fillStyle: part.color, strokeStyle: part.color, lineWidth: part.width ?? 1,
        globalAlpha: part.alpha ?? 1, lineJoin: "round" })
      pen.setLineDash(part.dash ?? [])
      for (const kind in parts) if (kind in part) parts[kind](part[kind], part)
      pen.setLineDash([])
    }
    pen.restore()
  }
  return { draw, place: (event) => scale.place(event.offsetX, event.offsetY), shown: () => picture }
}
