// The page's script: user actions go to Python as messages, one at a time; only the newest of each kind is kept.
export function render({ model }) {
  const at = (id) => document.getElementById(id)
  const all = (selector) => [...document.querySelectorAll(selector)]
  const waiting = new Map()
  const models = {}
  const sketches = Object.fromEntries(["history", "portrait", "circle"].map((name) => [name, sketch(at(name))]))
  let busy = 0, sent = 0, peeking = false, dragged = null, held = null, touched = false, drawing = false

  function ask(kind, message = {}) {
    const old = waiting.get(kind)
    if (kind === "set" && old) message = { words: { ...old.words, ...message.words } }
    if (kind === "step" && old) message = { right: old.right + message.right, up: old.up + message.up }
    waiting.delete(kind)
    waiting.set(kind, message)
    if (kind !== "peek" && kind !== "unpeek") waiting.delete("peek")
    next()
  }
  function next() {
    if (busy || waiting.size === 0) return
    const [kind, message] = waiting.entries().next().value
    waiting.delete(kind)
    busy = ++sent
    model.send_msg({ kind, number: busy, ...message })
  }

  // -- messages from Python
  model.on("msg:custom", ({ text, numbers }) => {
    const reply = JSON.parse(text, (_, part) => part?.to === undefined ? part : numbers.slice(part.from, part.to))
    if (reply.number) busy = 0
    draw(reply.pictures)
    if (reply.fault !== undefined) fault(reply.fault)
    // while the pointer is over the chart, results for the chosen point wait until the pointer has left
    if (reply.table && (reply.peek || reply.number || !peeking)) {
      peeking = reply.peek
      table(reply)
      at("place").textContent = reply.place
      at("where").textContent = reply.peek ? "under the pointer" : ""
      at("motions").classList.toggle("peeking", reply.peek)
    }
    if (reply.zones) {
      families(reply.zones)
      untab(document)
    }
    if (reply.status !== undefined) at("status").textContent = reply.status
    if (reply.fields) fields(reply.fields)
    if (reply.number && reply.query !== undefined) {
      history.replaceState(null, "", location.pathname + (reply.query ? "?" + reply.query : ""))
    }
    if (reply.searched !== undefined && (reply.peek || !peeking)) at("searched").textContent = reply.searched
    for (const name of ["mapped", "boxed"]) if (reply[name] !== undefined) at(name).textContent = reply[name]
    if (reply.physical !== undefined) {
      at("physical").textContent = reply.physical
      at("physical").hidden = !reply.physical
    }
    for (const name of ["map", "box"]) {
      if (reply[name] !== undefined) at(name).setAttribute("aria-pressed", String(reply[name]))
    }
    if (reply.box !== undefined) at("tolerances").hidden = !reply.box
    if (reply.run !== undefined) at("ran").textContent = reply.run
    if (reply.line !== undefined) reveal(reply.line)
    if (reply.diagram !== undefined) at("windows").textContent = reply.diagram
    if (reply.export !== undefined) exported(reply)
    next()
  })

  function draw(pictures) {
    for (const [name, picture] of Object.entries(pictures)) {
      if (name in sketches) sketches[name].draw(picture)
      else {
        if (picture.image) picture.data.image = [matrix(name, picture)]
        const { image, shape, ...rest } = picture
        found(name).setv(rest, { sync: false }) // not sent back to Python, which set it
      }
    }
  }
  function found(name) {
    return models[name] ??= Bokeh.documents[0].get_model_by_name(name)
  }
  // Bokeh's own type of two-dimensional array, as the data source has from the beginning
  function matrix(name, { image, shape }) {
    const old = found(name).data.image[0]
    return new old.constructor(image, shape)
  }
  // the tolerance box at another place, and whether a place is in it or within a few pixels of it
  function boxed() {
    const { left: [left], right: [right], bottom: [bottom], top: [top] } = found("zones.box").data
    return left === undefined ? null : { left, right, bottom, top }
  }
  function inBox(x, y) {
    const box = boxed(), plot = found("zones.plot"), near = 8
    if (!box) return null
    const { x_range, y_range, inner_width, inner_height } = plot
    const beside = near * (x_range.end - x_range.start) / inner_width
    const upward = (y_range.end / y_range.start) ** (near / inner_height)
    return x > box.left - beside && x < box.right + beside && y > box.bottom / upward && y < box.top * upward
      ? { ...box, x, y } : null
  }
  // the new centre of the dragged box: clearances by their ratio, as on the logarithmic axis
  function middle(x, y) {
    return { r: 0.5 * (held.left + held.right) + x - held.x, clearance: 0.5 * (held.bottom + held.top) * y / held.y }
  }
  function shift(x, y) {
    const { r, clearance } = middle(x, y), wide = 0.5 * (held.right - held.left), high = 0.5 * (held.top - held.bottom)
    found("zones.box").setv({ data: { left: [r - wide], right: [r + wide],
      bottom: [Math.max(clearance - high, 1e-3 * clearance)], top: [clearance + high] } }, { sync: false })
  }
  // Bokeh's figures would take the keyboard focus without a name or a visible mark; the chart around them has both
  function untab(root) {
    for (const one of root.querySelectorAll("*")) {
      if (one.classList.contains("bk-events")) one.tabIndex = -1
      if (one.shadowRoot) untab(one.shadowRoot)
    }
  }
  function fault(text) {
    at("fault").textContent = text
    at("fault").hidden = !text
  }
  function table({ table, peek, run, running }) {
    const lines = table.map((row) => line(row.definition, row.chosen, row.stable === "stable" ? "" : "unstable", [
      row.label, (row.stable === "stable" ? "● " : "○ ") + row.stable, row.attenuation, row.multiplier], row.kind, peek))
    if (run && !peek) lines.unshift(line(null, running, "", ["the simulation", "", "", ""], "", peek))
    const focused = document.activeElement && document.activeElement.name === "motion"
    at("table").replaceChildren(...lines)
    if (focused) at("table").querySelector("input:checked")?.focus()
    if (!lines.length) at("table").innerHTML = '<tr><td colspan="4">No motion with impacts was found here.</td></tr>'
  }
  function line(motion, chosen, kind, cells, note, peek) {
    const row = document.createElement("tr")
    row.className = kind + (chosen ? " chosen" : "")
    cells.forEach((text, j) => {
      const cell = document.createElement("td")
      if (j === 0) {
        const label = document.createElement("label"), radio = document.createElement("input")
        Object.assign(radio, { type: "radio", name: "motion", checked: chosen, disabled: Boolean(peek) })
        radio.addEventListener("change", () => ask("choose", { motion }))
        label.append(radio, " ", text)
        cell.append(label)
      } else cell.textContent = text
      if (j === 3 && note) {
        const small = document.createElement("small")
        small.textContent = " " + note
        cell.append(small)
      }
      row.append(cell)
    })
    return row
  }
  function families(zones) {
    at("families").replaceChildren(...zones.map(({ name, color, hatch }) => {
      const item = document.createElement("li"), swatch = document.createElement("b")
      swatch.className = "swatch"
      swatch.dataset.hatch = hatch
      Object.assign(swatch.style, { color, backgroundColor: color + "22" })
      item.append(swatch, " ", name)
      return item
    }))
  }
  function fields(values) {
    for (const [name, text] of Object.entries(values)) {
      const [, kind = "field", key] = name.match(/^(?:(run|box)_)?(.*)$/)
      for (const input of all(`[data-${kind}="${key}"]`)) {
        if (input !== document.activeElement || !input.dirty) input.value = text
      }
      for (const slider of all(`[data-slider="${name}"]`)) {
        if (slider === document.activeElement && waiting.has("set")) continue
        // a larger number in the field extends the range of the slider while it is there
        slider.max = Math.max(Number(text), Number(slider.dataset.max))
        slider.value = text
      }
    }
  }
  function reveal(line) {
    if (at("along").hidden === !line) return
    at("along").hidden = !line
    window.dispatchEvent(new Event("resize"))
  }
  function announce(text) {
    at("done").textContent = text
    setTimeout(() => { if (at("done").textContent === text) at("done").textContent = "" }, 4000)
  }
  async function copied(text, what) {
    try {
      await navigator.clipboard.writeText(text)
      announce(what + " copied")
    } catch {
      announce(what + " could not be copied; copy it by hand")
    }
  }
  function exported({ form, export: text }) {
    if (form === "namelist") {
      const file = document.createElement("a")
      file.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }))
      file.download = "explorer.nml"
      file.click()
      setTimeout(() => URL.revokeObjectURL(file.href), 10000)
      announce("explorer.nml saved")
    } else {
      const shown = at("export").querySelector("textarea")
      shown.value = text
      at("export").showModal()
      shown.setSelectionRange(0, 0)
      shown.scrollTop = 0
      copied(text, "Python")
    }
  }

  // -- user actions
  window.vibroimpact = {
    pointer(figure, event, x, y) {
      if (event === "mousemove" && !dragged && !touched) ask("peek", { r: x, clearance: y })
      if (event === "mouseleave") {
        waiting.delete("peek")
        ask("unpeek")
      }
      // Bokeh reports a second tap within 0.3 s as a double tap, wherever it is
      if (event === "tap" || event === "doubletap") {
        at("chart").focus({ preventScroll: true })
        ask("point", { r: x, clearance: y })
      }
      if (event === "panstart" && (drawing || !touched)) {
        held = inBox(x, y)
        dragged = [x, y]
      }
      if (event === "pan" && held) shift(x, y)
      if (event === "panend" && held) {
        ask("drag", middle(x, y))
        held = dragged = null
        draws(false)
      } else if (event === "panend" && dragged) {
        ask("line", { from: dragged, to: [x, y] })
        dragged = null
        draws(false)
      }
    },
    sketches,
    lost: () => {
      at("status").textContent = ""
      fault("The explorer has stopped. Start it again (vibroimpact explore) and reload this page: "
        + "its address contains what is shown.")
    },
    settled: () => !busy && waiting.size === 0
      && ["status", "mapped", "boxed"].every((name) => !/…$/.test(at(name).textContent)) && /were searched.$/.test(at("searched").textContent),
  }
  // a moving finger scrolls the page unless drawing is on
  function draws(on) {
    drawing = on
    at("draw").setAttribute("aria-pressed", String(on))
    at("chart").classList.toggle("drawing", on)
  }
  at("draw").addEventListener("click", () => draws(!drawing))
  document.addEventListener("pointercancel", () => {
    if (held) shift(held.x, held.y)
    dragged = held = null
  }, true)
  // a finger has no position until it taps
  for (const event of ["pointerdown", "pointermove"]) {
    document.addEventListener(event, (e) => { touched = e.pointerType === "touch" }, true)
  }
  at("portrait").addEventListener("click", (event) => {
    const [y, y_dot] = sketches.portrait.place(event)
    ask("launch", { y, y_dot })
  })
  all("[data-slider]").forEach((slider) => {
    const set = () => ask("set", { words: { [slider.dataset.slider]: slider.value } })
    let before = slider.value
    slider.addEventListener("input", set)
    // if a scrolling finger has moved a slider, the browser cancels the gesture and the value is restored
    slider.addEventListener("pointerdown", () => { before = slider.value })
    slider.addEventListener("pointercancel", () => {
      slider.value = before
      set()
    })
  })
  all("[data-field]").forEach((input) => {
    input.addEventListener("input", () => { input.dirty = true })
    input.addEventListener("change", () => {
      input.dirty = false
      ask("set", { words: { [input.dataset.field]: input.value } })
    })
  })
  all("[data-run]").forEach((input) => input.addEventListener("input", () => { input.dirty = true }))
  at("chart").addEventListener("keydown", (event) => {
    const size = event.shiftKey ? 0.1 : 0.01
    const steps = { ArrowLeft: [-size, 0], ArrowRight: [size, 0], ArrowUp: [0, size], ArrowDown: [0, -size] }
    if (event.key in steps) {
      const [right, up] = steps[event.key]
      ask("step", { right, up })
    } else if (event.key.toLowerCase() === "l") {
      ask("through", { across: event.shiftKey })
    } else if (event.key === "Escape") {
      draws(false)
      ask("erase")
    }
    else return
    event.preventDefault()
  })
  at("run").addEventListener("submit", (event) => {
    event.preventDefault()
    const words = {}
    for (const input of all("[data-run]")) {
      input.dirty = false
      words[input.dataset.run] = input.value
    }
    ask("run", { words })
  })
  const pressed = (name) => at(name).getAttribute("aria-pressed") === "true"
  at("map").addEventListener("click", () => ask("set", { words: { map: pressed("map") ? "off" : "on" } }))
  // at first around the point
  const words = () => Object.fromEntries(all("[data-box]").map((input) => [input.dataset.box, input.value]))
  const setBox = () => {
    const { r, clearance, r_half, clearance_half } = words()
    ask("set", { words: { box: [r, clearance, r_half, clearance_half].join(",") } })
  }
  at("box").addEventListener("click", () => pressed("box") ? ask("set", { words: { box: "" } }) : setBox())
  all("[data-box]").forEach((input) => {
    input.addEventListener("input", () => { input.dirty = true })
    input.addEventListener("change", () => {
      input.dirty = false
      setBox()
    })
  })
  at("stop").addEventListener("click", () => ask("stop"))
  at("erase").addEventListener("click", () => ask("erase"))
  at("namelist").addEventListener("click", () => ask("export", { form: "namelist" }))
  at("python").addEventListener("click", () => ask("export", { form: "python" }))
  at("link").addEventListener("click", () => copied(location.href, "Link"))
  at("close").addEventListener("click", () => at("export").close())
  ask("ready")
}
