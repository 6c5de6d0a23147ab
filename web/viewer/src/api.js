// A look at the page from outside, for tests and the console. Nothing can be changed through it.

export function exposeApi({ connection, live, view, splats, felt, haptics, hold, parameters }) {
  const api = {
    get ready() { return parameters.current !== null && live.isFresh('measured_cp') && splats.knowsFelt; },
    get connected() { return connection.connected; },
    get frames() { return view.frames; },
    get idle() { return splats.isSorting ? 0 : view.idle; },
    get sceneLoaded() { return splats.knowsFelt; },
    get held() { return hold.active; },
    get pulses() { return haptics.pulses.map((pulse) => ({ ...pulse })); },
    get presenting() { return view.renderer.xr.isPresenting; },
    parameters: () => structuredClone(parameters.current),
    fresh: (topic) => live.isFresh(topic),
    tool: () => live.tool?.position ?? null,
    proxy: () => live.proxy?.position ?? null,
    hand: () => hold.hand.toArray(),
    force: () => live.force,
    contacts: () => live.contacts.map(({ id, position, semiAxes, normal, depth }) =>
      ({ id, center: position, scale: semiAxes.map((s) => 2 * s), normal, depth })),
    drawnContacts: () => felt.contacts.count,
    centreOfDrawnContact: (id) => felt.drawnCentre(id),
    arrow: () => felt.force.direction,
    kept: () => splats.keptCount,
    felt: () => splats.feltCount,
    feltScale: (row) => splats.feltScale(row),
    project: (point) => view.project(point),
    pick: ([x, y]) => splats.pick(view.rayAt({ clientX: x, clientY: y }))?.toArray() ?? null,
  };
  window.palpateViewer = Object.freeze(api);
}
