/** Like viewer/start_worker.js, of the script that the page holds (start.js). @returns {Worker} */
export function startWorker() {
  const address = URL.createObjectURL(new Blob([ldpPage.worker], { type: 'text/javascript' }));
  const worker = new Worker(address);
  URL.revokeObjectURL(address);
  return worker;
}
