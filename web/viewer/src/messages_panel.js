// Panel: messages that the program has written to its terminal.

import { byId, element } from '../../shared/dom.js';

export function createMessagesPanel(connection) {
  const list = byId('messages');
  connection.subscribe('messages', 'std_msgs/String', ({ data }) => {
    list.replaceChildren(...JSON.parse(data).map((text) => element('li', { text })));
    list.lastChild?.scrollIntoView?.({ block: 'nearest' });
  });
}
