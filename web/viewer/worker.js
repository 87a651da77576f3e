// The worker of a viewer: takes {file}, tells what prepare() tells.
import { prepare } from './preparation.js';

self.onmessage = ({ data: { file } }) => prepare(file, (message, transferred = []) => self.postMessage(message, transferred));
