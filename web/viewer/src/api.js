// Read-only access to the state of the page, for tests and the console.

export function exposeApi({ connection, live, view, splats, felt, cues, hold, parameters, depth, headset, plots }) {
  const api = {
    get ready() { return parameters.current !== null && live.isFresh('measured_cp') && splats.knowsFelt; },
    get connected() { return connection.connected; },
    get frames() { return view.frames; },
    get sceneFrames() { return view.sceneFrames; },
    get idle() { return splats.isSorting ? 0 : view.idle; },
    get sceneLoaded() { return splats.knowsFelt; },
    get held() { return hold.active; },
    get pulses() { return cues.haptics.pulses.map((pulse) => ({ ...pulse })); },
    get sound() { return { on: cues.sound.on, level: cues.sound.level, texture: cues.sound.texture, knocks: cues.sound.knocks }; },
    get approaching() { return hold.holds('approach'); },
    get gap() { return depth.gap?.length ?? null; },
    vr: () => ({
      lines: headset.panel.lines, panel: headset.panel.isShown, hovered: headset.panel.hovered, stopFrame: headset.signs.frame.visible, dark: headset.signs.dark.visible,
      marker: headset.signs.arrow.visible, pointsTo: headset.signs.arrow.position.toArray(), aiming: headset.teleport.group.visible, floor: headset.surroundings.group.visible,
      drawn: headset.hands.map(({ grip, joints, isTracked }) => (isTracked ? Object.values(joints.joints).filter((j) => j.children.length > 0) : grip.children).length),
      frameTime: headset.frames.mean,
    }),
    pointing: () => {
      const { origin, direction } = headset.hands.find((hand) => hand.source?.handedness === 'right').pointing;
      return { origin: origin.toArray(), direction: direction.toArray() };
    },
    panelButton: (name) => headset.panel.placeOf(name).toArray(),
    plotTops: () => plots.tops,
    cue: () => (depth.contact.visible ? 'contact' : depth.line.visible ? 'gap' : ''),
    get presenting() { return view.renderer.xr.isPresenting; },
    parameters: () => structuredClone(parameters.current),
    fresh: (topic) => live.isFresh(topic),
    tool: () => live.tool?.position ?? null,
    proxy: () => live.proxy?.position ?? null,
    turn: () => live.tool?.orientation ?? null,
    hand: () => hold.hand.toArray(),
    force: () => live.force,
    contacts: () => live.contacts.map(({ id, position, semiAxes, normal, depth }) =>
      ({ id, center: position, scale: semiAxes.map((s) => 2 * s), normal, depth })),
    drawnContacts: () => felt.contacts.count,
    others: () => live.others,
    drawnOthers: () => felt.others.count,
    centreOfDrawnContact: (id) => felt.drawnCentre(id),
    arrow: () => felt.force.direction,
    kept: () => splats.keptCount,
    felt: () => splats.feltCount,
    feltScale: (row) => splats.feltScale(row),
    axes: () => Object.fromEntries(Object.entries(view.axesOfCamera).map(([name, axis]) => [name, axis.toArray()])),
    toolPixels: () => (2 * felt.size) / view.pixelAt(live.tool.position), // diameter on the page
    project: (point) => view.project(point),
    seenOpacity: ([x, y]) => splats.look(view.rayAt({ clientX: x, clientY: y }))?.opacity ?? 0,
    pick: ([x, y]) => splats.pick(view.rayAt({ clientX: x, clientY: y }))?.toArray() ?? null,
  };
  window.palpateViewer = Object.freeze(api);
}
